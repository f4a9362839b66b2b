"""Records as JSON: plain data, written row by row and read with errors that help."""

import dataclasses
import difflib
import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from ..errors import few, short
from . import writing

FORMAT = 1  # of the files; those without the key are from before it
DIGITS = 300  # a longer whole number is read as a float: infinite from 1e309
DEEPEST = 5  # lists within lists: pairs of matrices are the deepest that is written
WORDS = {True: "true", False: "false", None: "null"}
ELSEWHERE = {  # what other programs call the keys of a plant
    "Ts": "dt is the sampling period in seconds",
    "D": "E is the matrix from u to y",
    "QN": "Q is the covariance of w in x+ = A x + w: Q = G QN G'",
    "RN": "R is the covariance of one reading: RN, of continuous time RN / dt",
    "NN": "S is the covariance of w and v",
    "G": "Q is that of w in x+ = A x + w: Q = G QN G'",
    "H": "C is the matrix from x to y",
}


class Dataclass(Protocol):
    """An instance of a dataclass."""

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]


Record = TypeVar("Record", bound=Dataclass)


@dataclass(frozen=True)
class JsonFile:
    """A JSON file that was read: its path, its text, and the object in it."""

    path: str | Path
    text: str
    data: dict[str, Any]


def json_file(path: str | Path | JsonFile, what: str) -> JsonFile:
    """Read the object in a JSON file; `require_plain` is for its entries.

    Parameters
    ----------
    path : str, Path or JsonFile
        One that was read already is returned as it is.
    what : str
        What the file should hold, for messages.

    Raises
    ------
    ValueError
        If the file is not JSON, and where, or if a key occurs twice.
    """
    if isinstance(path, JsonFile):
        return path
    content = Path(path).read_bytes()
    try:
        text = content.decode("utf-8-sig")
        data = json.loads(text, object_pairs_hook=_distinct, parse_int=_whole)
    except UnicodeDecodeError:
        raise ValueError(
            f"{path}: not a JSON file in UTF-8; save it as UTF-8"
        ) from None
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}: not a JSON file: {_mistake(error)}") from None
    except RecursionError:
        raise ValueError(f"{path}: not a JSON file: nested too deeply") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not isinstance(data, dict):
        raise ValueError(f"{path}: {what} is a JSON object, got {type(data).__name__}")
    return JsonFile(path, text, data)


def _mistake(error: json.JSONDecodeError) -> str:
    """Behind what a text stops to be JSON, and what is wrong there."""
    before, after = error.doc[: error.pos].rstrip(), error.doc[error.pos :].lstrip()
    line, why = before.count("\n") + 1, error.msg
    if after.startswith(("/", "#")):
        why = 'JSON has no comments; the key "description" may hold words'
    elif before.endswith(",") and after.startswith(("]", "}")):
        why = "a comma that nothing follows; remove it"
    elif why.startswith("Illegal trailing comma"):  # Python 3.13
        why = "a comma that nothing follows; remove it"
    elif why.startswith("Expecting ','"):
        why = "a comma or a bracket is missing"
    return f"line {line}, behind {short(before.rpartition(chr(10))[2][-50:])}: {why}"


def _distinct(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        (twice, _), *_ = Counter(key for key, _ in pairs).most_common(1)
        raise ValueError(f"the key {short(twice)} occurs more than once")
    return found


def _whole(digits: str) -> float:
    return int(digits) if len(digits) <= DIGITS else float(digits)


def require_plain(at: str, value: object, deep: int = 0) -> None:
    """Raise unless everything within is text, a finite number, a list or an object.

    NumPy would take true for 1 and null for NaN.
    """
    if deep > DEEPEST:
        raise ValueError(f"{at} is nested too deeply")
    if value is None or isinstance(value, bool):
        raise ValueError(f"{at} holds {WORDS[value]}, which is not a number")
    if isinstance(value, float) and not math.isfinite(value):
        what = "NaN" if math.isnan(value) else "one is beyond 1.8e308"
        raise ValueError(f"{at} has entries that are not finite: {what}")
    inner = list(value.values()) if isinstance(value, dict) else value
    for one in inner if isinstance(inner, list) else ():
        require_plain(at, one, deep + 1)


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
    writing.write(path, layout(data))


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
    file = json_file(path, _one(kind))
    fields = {field.name for field in dataclasses.fields(cls)}
    data = _entries(file, kind, fields | {"description"})
    missing = [key for key in required if key not in data]
    if missing:
        raise ValueError(f"{file.path}: the {kind} has no {str(missing)[1:-1]}")
    given = {key: value for key, value in data.items() if key in fields}
    if kind == "plant" and isinstance(given.get("U"), dict):
        model = JsonFile(f"{file.path}: U", "", given["U"])
        given["U"] = read(model, kind, cls, required, **defaults)
    try:
        return cls(**defaults | given)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{file.path}: {error}") from None


OTHERWISE = {("observer", "plant"): "; `luenberger filter` takes a plant"}


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
            + "".join(_hint(key, known) for key in unknown[:3])
        )
    data = {key: value for key, value in data.items() if value is not None}
    for key, value in data.items():
        require_plain(f"{path}: {key}", value)
    found = {key: _array(path, key, value) for key, value in data.items()}
    return found if said is None else found | {"at_first": said == "prior"}


def _hint(key: str, known: set[str]) -> str:
    """What an unknown key may mean."""
    if key in ELSEWHERE:
        return f". For {key!r}: {ELSEWHERE[key]}"
    near = {one.lower(): one for one in known}
    alike = difflib.get_close_matches(key.lower(), near, 1, 0.75)
    return f". Is {short(key)} meant for {near[alike[0]]!r}?" if alike else ""


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
