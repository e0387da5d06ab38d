"""Printed numbers of a case, from the `reference.csv` beside its `run.py`.

Depends on: nothing.
"""

from __future__ import annotations

import csv
from pathlib import Path


def printed(beside: str) -> dict[str, float]:
    """Column `expected` of the reference.csv beside the file `beside`, by its first column."""
    file = Path(beside).with_name("reference.csv")
    with file.open(encoding="utf-8", newline="") as lines:
        return {row["quantity"]: float(row["expected"]) for row in csv.DictReader(lines)}
