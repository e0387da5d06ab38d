"""What a command wrote, and which earlier files it replaced.

Depends on: nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def earlier(folder: Path) -> frozenset[Path]:
    """Files that are in `folder` before anything is written."""
    return frozenset(folder.iterdir()) if folder.is_dir() else frozenset()


def written_lines(paths: Iterable[Path], before: frozenset[Path]) -> list[str]:
    r"""The files under a heading, those that replaced an earlier one marked; none for none.

    Examples
    --------
    >>> print(*written_lines([Path("a/x.nc")], frozenset([Path("a/x.nc")])), sep="\n")
    <BLANKLINE>
    Written
      a/x.nc  (replaced an earlier one: --out FOLDER keeps both)
    """
    note = "  (replaced an earlier one: --out FOLDER keeps both)"
    lines = [f"  {path}{note if path in before else ''}" for path in paths]
    return ["", "Written", *lines] if lines else []
