"""What is settled before NumPy and hypothesis are loaded."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # two workers share two cores

import drawn  # noqa: E402, F401  registers the profile of `--hypothesis-profile=long`
