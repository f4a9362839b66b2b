"""Records as JSON: plain data, written row by row and read within limits."""

import dataclasses
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from ..errors import few, short
from . import atomic, json_files
from .json_files import JsonFile

FORMAT = 1  # of the files; those without the key are from before it


class Dataclass(Protocol):
    """An instance of a dataclass."""

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]


Record = TypeVar("Record", bound=Dataclass)


def as_data(kind: str, frozen: Dataclass) -> dict[str, object]:
    """A record as lists, numbers and strings, headed by what it is; None left out."""
    data = {"luenberger": kind, "format": FORMAT}
    for field in dataclasses.fields(frozen):
        name, value = field.name, getattr(frozen, field.name)
        inner = dataclasses.is_dataclass(value) and not isinstance(value, type)
        value = as_data(kind, value) if inner else plain(value)
        if name == "at_first":  # a file has no truth values
            name, value = "P0_is", "prior" if value else None
        if value is not None and value != [] and value != {}:
            data[name] = value
    return data


def plain(value: object) -> object:
    if isinstance(value, np.ndarray) and np.iscomplexobj(value):
        return {"real": value.real.tolist(), "imag": value.imag.tolist()}
    if isinstance(value, np.ndarray):
        # an empty matrix has lost a dimension as nested lists, so keep its shape
        return value.tolist() if value.size else {"shape": list(value.shape)}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return value


def write(path: str | Path, data: Mapping[str, object]) -> None:
    """Write JSON; an old file survives a failure."""
    text = layout(data)
    if len(text) > json_files.LARGEST * json_files.MIB:
        raise ValueError(
            f"{path}: this would be larger than the {json_files.LARGEST} MiB that are "
            "read back; use numpy.savez for the matrices"
        )
    atomic.write(path, text)


def layout(data: Mapping[str, object]) -> str:
    """JSON text with one key, or one row of a matrix, to a line."""
    lines = []
    for key, value in data.items():
        text = json.dumps(value, allow_nan=False)
        if text.startswith("[["):
            text = text.replace("], [", "],\n    [").replace("[[", "[\n    [", 1)
            text = text.removesuffix("]") + "\n  ]"
        lines.append(f"  {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def kind(file: JsonFile) -> str:
    """What a `JsonFile` holds, "plant" or "observer"; by its keys, if need be."""
    return file.data.get("luenberger", "observer" if "F" in file.data else "plant")


def read(
    path: str | Path | JsonFile,
    kind: str,
    cls: type[Record],
    required: Iterable[str],
    **defaults: object,
) -> Record:
    """Make a record from a JSON object of known keys, lists, numbers and strings.

    Parameters
    ----------
    path : str, Path or JsonFile
    kind : "plant" or "observer"
    cls : type
        A dataclass whose fields are the keys.  A "description" is allowed in any file
        and left out where the class has no such field.
    required : sequence of str
        Keys that must be there.
    **defaults
        Values of keys that may be absent, where the class has none.
    """
    file = json_files.json_file(path, _one(kind))
    fields = {field.name for field in dataclasses.fields(cls)}
    data = _entries(file, kind, fields | {"description"})
    missing = [key for key in required if key not in data]
    if missing:
        raise ValueError(f"{file.path}: the {kind} has no {str(missing)[1:-1]}")
    given = {key: value for key, value in data.items() if key in fields}
    if kind == "plant" and isinstance(given.get("U"), dict):
        model = JsonFile(Path(f"{file.path}: U"), b"", given["U"])
        given["U"] = read(model, kind, cls, required, **defaults)
    try:
        return cls(**defaults | given)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{file.path}: {error}") from None


OTHERWISE = {("observer", "plant"): "; `python -m luenberger filter` takes a plant"}


def _entries(file: JsonFile, kind: str, known: set[str]) -> dict[str, Any]:
    """What the file of a record has under known keys, null left out."""
    path, data = file.path, dict(file.data)
    said = data.pop("luenberger", kind)
    if said != kind:
        raise ValueError(
            f"{path}: this file does not hold {_one(kind)}: its key 'luenberger' says "
            f"{short(said)}"
            + OTHERWISE.get((kind, said if said == "plant" else ""), "")
        )
    _check_format(path, data.pop("format", FORMAT))
    said = data.pop("P0_is", None) if kind == "plant" else None
    if said not in (None, "prior", "posterior"):
        raise ValueError(
            f"{path}: P0_is must be 'prior' or 'posterior', got {short(said)}"
        )
    about = data.get("description")
    if not isinstance(about, str | None):
        raise ValueError(f"{path}: description must be text, got {short(about)}")
    unknown = sorted(set(data) - known)
    if unknown:
        raise ValueError(
            f"{path}: unknown keys {few(unknown)}; {_one(kind)} has {sorted(known)}"
        )
    data = {key: value for key, value in data.items() if value is not None}
    for key, value in data.items():
        json_files.require_plain(f"{path}: {key}", value)
    found = {key: _array(path, key, value) for key, value in data.items()}
    return found if said is None else found | {"at_first": said == "prior"}


def _check_format(path: str | Path, number: object) -> None:
    """Refuse a file of a later format: its keys may mean something else."""
    if type(number) is not int or number < 1:
        raise ValueError(f"{path}: format must be a whole number, got {short(number)}")
    if number > FORMAT:
        raise ValueError(
            f"{path}: the file has format {number}, and this version of luenberger "
            f"reads format {FORMAT}; update luenberger"
        )


def _one(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def _numbers(path: str | Path, key: str, value: object) -> np.ndarray:
    try:
        array = np.array(value)
    except ValueError:
        array = np.array("ragged")
    if array.size and array.dtype.kind not in "iuf":
        raise ValueError(f"{path}: {key} must be an array of real numbers")
    return array.astype(float)


def _array(path: str | Path, key: str, value: object) -> object:
    """Turn {"shape": [0, n]} back into an empty array, {"real", "imag"} into a
    complex one, also in a list of pairs of matrices; pass other data on.
    """
    if key == "multiplicative" and isinstance(value, list):
        return [_array(path, key, one) for one in value]
    if not isinstance(value, dict) or key in (
        "estimates",
        "U",
    ):  # rows by name, a plant
        return value
    if set(value) == {"real", "imag"}:
        real, imag = (_numbers(path, key, value[k]) for k in ("real", "imag"))
        if real.shape != imag.shape:
            raise ValueError(
                f"{path}: {key} has a real part of shape {real.shape} and an "
                f"imaginary one of shape {imag.shape}"
            )
        both = np.empty(real.shape, dtype=complex)
        both.real, both.imag = real, imag
        return both
    shape = value.get("shape")
    if set(value) != {"shape"} or not isinstance(shape, list) or 0 not in shape:
        raise ValueError(f"{path}: {key} must be numbers or lists, not an object")
    sizes = all(type(size) is int and 0 <= size < 10**6 for size in shape)
    if not sizes or len(shape) > 3:
        raise ValueError(f"{path}: {key} has the shape {short(shape)}")
    return np.zeros(shape)
