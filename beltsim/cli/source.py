"""What a FILE on the command line holds: a drive, and how a stored run was made from it.

Depends on: drive, errors, io.
"""

from __future__ import annotations

import json
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from beltsim.drive import Drive, load_drive
from beltsim.errors import InvalidDriveError, ResultFileError
from beltsim.io import is_result_file, stored_inputs


@dataclass(frozen=True)
class Source:
    """A drive with the text it was read from.

    Parameters
    ----------
    drive : Drive
    text, suffix : str
        The drive file itself, ``.toml`` or ``.json``.
    arguments : dict
        Command-line arguments of the stored run; empty for a drive file.
    is_result : bool
        Whether it came from a result file.
    """

    drive: Drive
    text: str
    suffix: str
    arguments: dict[str, Any] = field(default_factory=dict)
    is_result: bool = False


def read_source(path: str) -> Source:
    """The drive in `path`, a drive file or a result of `beltsim run`.

    Raises
    ------
    InvalidDriveError
        With every mistake in a drive file.
    ResultFileError
        For a result file that cannot be read or holds no drive.
    """
    if is_result_file(path):
        return _stored(path)
    drive = load_drive(path)  # refuses what is too large to be read
    file = Path(path)
    suffix = ".json" if file.suffix.lower() == ".json" else ".toml"
    return Source(drive, file.read_text(encoding="utf-8-sig"), suffix)


def _stored(path: str) -> Source:
    inputs = stored_inputs(path)
    text, suffix, arguments = (inputs.get(key) for key in ("drive", "suffix", "arguments"))
    if not isinstance(text, str) or suffix not in (".toml", ".json"):
        raise ResultFileError(f"{path} holds no drive file; it was not written by `beltsim run`")
    if not isinstance(arguments, dict):
        raise ResultFileError(f"{path} is damaged: the arguments of its run are no table")
    try:
        tables = json.loads(text) if suffix == ".json" else tomllib.loads(text)
    except ValueError as error:
        raise InvalidDriveError(f"{path}: the drive file in it: {error}") from error
    return Source(Drive.model_validate(tables), text, suffix, arguments, is_result=True)
