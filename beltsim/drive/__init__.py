"""Drives: files, checks and geometry, in SI units with English names.

`load_drive` reads a drive file, `Drive` is its content, `Drive.layout` its geometry, `presets`
holds drives known by name, `template` and `json_schema` explain the file.

Depends on: errors, checks; pydantic, numpy.
"""

from __future__ import annotations

from beltsim.drive.layout import Layout
from beltsim.drive.reading import load_drive
from beltsim.drive.schema import (
    Belt,
    CrankOrder,
    Damping,
    Drive,
    Excitation,
    ExcitationOrder,
    OperatingPoint,
    Overrides,
    Pulley,
    Tensioner,
)
from beltsim.drive.writing import json_schema, template

__all__ = [
    "Belt",
    "CrankOrder",
    "Damping",
    "Drive",
    "Excitation",
    "ExcitationOrder",
    "Layout",
    "OperatingPoint",
    "Overrides",
    "Pulley",
    "Tensioner",
    "json_schema",
    "load_drive",
    "template",
]
