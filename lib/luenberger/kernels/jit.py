"""Generated modules for numba, whose machine code is kept for the next process."""

import hashlib
from functools import cache
from typing import Any

from . import inside
from .kept import ours, private, replace, sources, usable_folder


@cache
def jitted(text: str) -> Any:
    """The function `run` of a module, to be compiled for what it is called with.

    The module lies in the folder of texts that are `kept`, and numba's files below it.
    """
    import numba
    from numba.extending import register_jitable

    for one in inside.FUNCTIONS:
        register_jitable(one)
    folder, path = usable_folder(), None
    if folder is not None:
        below = folder / "__pycache__"  # where numba puts its files
        below.mkdir(mode=0o700, exist_ok=True)
        if private(below):
            name = hashlib.sha256(f"{sources()}\0{text}".encode()).hexdigest()[:32]
            path = folder / f"run_{name}.py"
            if not (path.is_file() and ours(path) and path.read_text() == text):
                replace(path, text)
    space: dict[str, Any] = {"__name__": inside.__name__}  # a module that there is
    exec(compile(text, str(path or "<generated>"), "exec"), space)  # made by us
    ways: dict[str, Any] = dict(error_model="numpy", nogil=True, cache=path is not None)
    return numba.njit(**ways)(space["run"])
