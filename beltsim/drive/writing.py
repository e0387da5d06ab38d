"""Drives as text: the drive file of a `Drive`, a commented template, the JSON schema.

Depends on: schema; tomli_w.
"""

from __future__ import annotations

from importlib import resources
from typing import Any

from beltsim.drive.schema import Drive


def to_toml(drive: Drive) -> str:
    """The text of a drive file that loads as a drive equal to `drive`."""
    import tomli_w  # loads only when a drive is written

    return tomli_w.dumps(drive.model_dump(exclude_none=True))


def template() -> str:
    """A commented drive file that explains every key and loads as it stands."""
    source = resources.files("beltsim.drive").joinpath("template.toml")
    return source.read_text(encoding="utf-8")


def json_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a drive file.

    It states types and ranges of single values; what needs several (the layout, names that must
    differ, a static friction torque below the kinetic one) is checked when a drive is loaded.

    Examples
    --------
    >>> json_schema()["required"]
    ['crank_rotation', 'pulleys', 'belt', 'damping', 'operating_point']
    """
    schema = Drive.model_json_schema()
    for table in (schema, *schema["$defs"].values()):
        for entry in table["properties"].values():
            entry.pop("title", None)  # made from the key, with its unit in capitals
    schema["description"] = "A belt drive, the content of one drive file of beltsim."
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | schema
