"""C source as a library that Python calls, on a machine with a C compiler."""

import ctypes
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory


def compiler() -> str | None:
    """The C compiler of this machine, or None."""
    return shutil.which("cc") or shutil.which("gcc")


def library(texts: Mapping[str, str], otherwise: str) -> ctypes.CDLL:
    """Files by name, those in .c compiled together in C99 and loaded.

    Raises
    ------
    RuntimeError
        If there is no C compiler; `otherwise` says what to do without.
    """
    command = compiler()
    if command is None:
        raise RuntimeError(
            f"this takes a C compiler, and there is neither cc nor gcc; {otherwise}"
        )
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        made = Path(folder) / "library.so"
        for name, text in texts.items():
            (Path(folder) / name).write_text(text)
        sources = [str(Path(folder) / name) for name in texts if name.endswith(".c")]
        options = "-std=c99 -O2 -shared -fPIC -o".split()
        whole = [command, *options, str(made), *sources, "-lm"]
        subprocess.run(whole, check=True, capture_output=True)
        return ctypes.CDLL(str(made))
