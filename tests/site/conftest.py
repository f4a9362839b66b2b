"""What the tests of pages share: the pages, and a browser to look at them."""

import browsing
import pytest
import site_build


@pytest.fixture(scope="session")
def site(tmp_path_factory, worker_id):
    """The pages, built once in a run, however many workers it has."""
    if reason := site_build.missing():
        pytest.skip(reason)
    if worker_id == "master":
        return site_build.build(tmp_path_factory.mktemp("site"))
    return site_build.build_once(tmp_path_factory.getbasetemp().parent / "site")


@pytest.fixture(scope="module")
def browser():
    if reason := browsing.missing():
        pytest.skip(reason)
    with browsing.chromium_running() as browser:
        yield browser
