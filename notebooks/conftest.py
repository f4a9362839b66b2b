"""Every notebook here is a test, of its outputs and of how it is stored."""

from loaded_by_kernels import MODULES
from notebook_tests import forked
from notebook_tests.in_pytest import *  # noqa: F403

forked.use(*MODULES)

# these run inside nbgrader and Sphinx only
collect_ignore = ["conf.py", "pages/extensions"]
collect_ignore_glob = ["coursework/*.py"]
