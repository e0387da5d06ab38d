"""Drive files: TOML, or JSON with the same keys.

Depends on: errors, schema.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

from beltsim.drive.schema import Drive
from beltsim.errors import InvalidDriveError

#: Largest drive file that is read, bytes.
MAX_BYTES = 1_000_000
#: How files begin that are given in place of a drive file.
_LOOKS = (
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "a ZIP archive, or a spreadsheet or document of an office program"),
    (b"\x1f\x8b", "compressed by gzip"),
    (b"\x89HDF", "a netCDF (HDF5) file; results are read by `beltsim.load`"),
    (b"CDF", "a classic netCDF file, which beltsim does not write"),
    (b"\xff\xfe", "UTF-16 text; save it as UTF-8"),
    (b"\xfe\xff", "UTF-16 text; save it as UTF-8"),
)


def load_drive(path: str | PathLike[str]) -> Drive:
    """Read and check a drive file.

    Parameters
    ----------
    path : path-like
        A TOML file, or a JSON file whose name ends in ``.json``, of at most 1 MB.

    Returns
    -------
    Drive

    Raises
    ------
    InvalidDriveError
        When the file cannot be read or parsed, or with every mistake found in it.
    """
    file = Path(path)
    text = _text(file)
    parse = _parse_json if file.suffix.lower() == ".json" else tomllib.loads
    return Drive.model_validate(_parsed(file, text, parse))


def _text(file: Path) -> str:
    """Content of `file`, without ever reading more than the limit."""
    try:
        if file.is_dir():
            raise InvalidDriveError(f"{file}: a folder; name the drive file in it")
        if file.exists() and not file.is_file():
            raise InvalidDriveError(f"{file}: not a regular file")
        size, look = file.stat().st_size, _looks_like(file)
        if size <= MAX_BYTES:
            with file.open("rb") as stream:
                raw = stream.read(MAX_BYTES + 1)
            size = len(raw)
    except FileNotFoundError as error:
        message = f"{file}: no such file; `beltsim init` writes a drive file to start from"
        raise InvalidDriveError(message) from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        reason = getattr(error, "strerror", None) or str(error)
        raise InvalidDriveError(f"{str(file)!r}: cannot be read ({reason})") from error
    if look:
        raise InvalidDriveError(f"{file}: no drive file but {look}")
    if size > MAX_BYTES:
        raise InvalidDriveError(
            f"{file}: {size} bytes; a drive file has at most {MAX_BYTES} (is it the right file?)"
        )
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InvalidDriveError(
            f"{file}: line {line} is not UTF-8 text (byte 0x{raw[error.start]:02x}); "
            "save the file as UTF-8"
        ) from error


def _looks_like(file: Path) -> str:
    """What a file is that cannot be a drive file, by its first bytes and its name."""
    with file.open("rb") as stream:
        first = stream.read(512)
    for signature, what in _LOOKS:
        if first.startswith(signature):
            return what
    if file.stat().st_size > MAX_BYTES:
        return ""  # its size is said
    if file.suffix.lower() == ".nc":
        return "something else whose name ends in .nc: it is no netCDF file either"
    return "binary data" if b"\0" in first else ""


def _parsed(file: Path, text: str, parse: Callable[[str], Any]) -> Any:
    try:
        return parse(text)
    except RecursionError as error:
        raise InvalidDriveError(f"{file}: tables or lists nested too deep") from error
    except ValueError as error:  # both parsers' errors, which name the line
        raise InvalidDriveError(f"{file}: {error}") from error


def _parse_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_unique)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object; a key given twice is a mistake (TOML refuses it by itself)."""
    table: dict[str, Any] = {}
    for key, value in pairs:
        if key in table:
            raise ValueError(f"key {key[:60]!r} is given twice in one object")
        table[key] = value
    return table
