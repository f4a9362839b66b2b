"""The scripts are run by `test_journeys`, and not looked into for tests."""

import pathlib

HERE = pathlib.Path(__file__).parent
collect_ignore = [
    path.name for path in HERE.glob("*.py") if not path.name.startswith("test_")
]
