"""Registers the profile that `--hypothesis-profile=long` asks for, before it does."""

import drawn  # noqa: F401
