"""Every notebook here is a test, of its outputs and of how it is stored."""

from notebook_tests.in_pytest import *  # noqa: F403

# these run inside nbgrader and Sphinx only
collect_ignore = ["coursework/nbgrader_config.py", "conf.py", "pages/extensions"]
