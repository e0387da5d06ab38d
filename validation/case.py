"""One validation case as data: reading `case.toml`, and refusing an incomplete one.

Every mistake of a file is collected before it is refused. A tolerance without its reason is a
mistake like any other.

Depends on: nothing.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

KINDS = ("exact", "independent", "published-number")
METRICS = ("value", "relative", "max", "rms", "count", "at_most")
RUNTIMES = ("quick", "full")
EXPECTED_VERDICTS = ("agrees", "disagrees-explained")
#: Seconds after which a case is stopped, unless its file says otherwise.
TIME_LIMITS_S = {"quick": 60.0, "full": 1800.0}

_TEXTS = ("title", "claim", "source", "quantity", "tolerance_reason")
_REQUIRED = ("title", "claim", "source", "kind", "quantity", "metric", "tolerance")
_KNOWN = {
    *_REQUIRED,
    *("tolerance_reason", "runtime", "expected_verdict", "explanation"),
    *("time_limit_s", "explained", "override", "needs"),
}


class CaseError(Exception):
    """A case file that cannot be used; `mistakes` lists everything wrong with it."""

    def __init__(self, name: str, mistakes: list[str]) -> None:
        self.mistakes = tuple(mistakes)
        super().__init__("\n".join(f"{name}: {mistake}" for mistake in mistakes))


@dataclass(frozen=True)
class Explained:
    """A row known to disagree: the number recorded when it was explained.

    Parameters
    ----------
    quantity : str
        Name of the row.
    got : float
        What beltsim gave when the explanation was written.
    within : float
        How far `got` may wander before the explanation no longer covers it.
    explanation : str
        Why; empty: the explanation of the whole case holds.
    """

    quantity: str
    got: float
    within: float
    explanation: str = ""


@dataclass(frozen=True)
class Override:
    """Another metric or tolerance for one row, with its own reason."""

    quantity: str
    tolerance: float
    tolerance_reason: str
    metric: str


@dataclass(frozen=True)
class Case:
    """What a case claims and how closely it must hold.

    Parameters
    ----------
    name : str
        ``family/case``.
    folder : Path
        Where it lies.
    title, claim, source, kind, quantity, metric, tolerance, tolerance_reason, runtime
        As in `case.toml`; see ``validation/README.md``.
    expected_verdict : str
        ``agrees`` or ``disagrees-explained``.
    explanation : str
        Why it disagrees; empty for a case that agrees.
    explained, overrides : tuple
        Settings for single rows.
    time_limit_s : float
        Seconds after which it is stopped and counted as failed.
    needs : str
        Module of the optional extra `peers`, without which the case is skipped; empty: none.
    """

    name: str
    folder: Path
    title: str
    claim: str
    source: str
    kind: str
    quantity: str
    metric: str
    tolerance: float
    tolerance_reason: str
    runtime: str
    expected_verdict: str
    explanation: str
    explained: tuple[Explained, ...]
    overrides: tuple[Override, ...]
    time_limit_s: float
    needs: str = ""


def find(root: Path) -> dict[str, Path]:
    """Folders of all the cases below `root`, by name ``family/case``, sorted."""
    files = sorted(root.glob("*/*/case.toml"))
    return {f"{file.parent.parent.name}/{file.parent.name}": file.parent for file in files}


def load(folder: Path) -> Case:
    """Read the case in `folder`.

    Raises
    ------
    CaseError
        With every mistake in the file: missing keys, unknown keys, values out of range, a
        tolerance without a reason, an explanation without a recorded number.
    """
    name = f"{folder.parent.name}/{folder.name}"
    try:
        data = tomllib.loads((folder / "case.toml").read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        raise CaseError(name, [f"case.toml cannot be read: {error}"]) from error
    mistakes = _mistakes(data, folder)
    if mistakes:
        raise CaseError(name, mistakes)
    runtime = data["runtime"]
    return Case(
        name=name,
        folder=folder,
        **{key: data[key] for key in _REQUIRED if key != "tolerance"},
        tolerance=float(data["tolerance"]),
        tolerance_reason=_one_line(data["tolerance_reason"]),
        runtime=runtime,
        expected_verdict=data.get("expected_verdict", "agrees"),
        explanation=_one_line(data.get("explanation", "")),
        explained=tuple(
            Explained(
                entry["quantity"],
                float(entry["got"]),
                float(entry["within"]),
                _one_line(entry.get("explanation", "")),
            )
            for entry in data.get("explained", ())
        ),
        overrides=tuple(
            Override(
                entry["quantity"],
                float(entry["tolerance"]),
                _one_line(entry["tolerance_reason"]),
                entry.get("metric", data["metric"]),
            )
            for entry in data.get("override", ())
        ),
        time_limit_s=float(data.get("time_limit_s", TIME_LIMITS_S[runtime])),
        needs=data.get("needs", ""),
    )


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _mistakes(data: Mapping[str, Any], folder: Path) -> list[str]:
    """Everything wrong with the contents of a case file."""
    found = [f"unknown key {key!r}" for key in data if key not in _KNOWN]
    required = (*_REQUIRED, "tolerance_reason", "runtime")
    found += [f"{key} is missing" for key in required if key not in data]
    for key in _TEXTS:
        if key in data and not _is_text(data[key]):
            found.append(f"{key} = {data[key]!r}: must be a text that says something")
    for key, allowed in (("kind", KINDS), ("metric", METRICS), ("runtime", RUNTIMES)):
        if key in data and data[key] not in allowed:
            found.append(f"{key} = {data[key]!r}: must be one of {', '.join(allowed)}")
    if "tolerance" in data and not _is_number(data["tolerance"], least=0.0):
        found.append(f"tolerance = {data['tolerance']!r}: must be a finite number >= 0")
    limit = data.get("time_limit_s", 1.0)
    if not _is_number(limit, least=1e-3):
        found.append(f"time_limit_s = {limit!r}: must be a number of seconds > 0")
    if not _is_text(data.get("needs", "none")):
        found.append(f"needs = {data['needs']!r}: must be the name of a module")
    found += _explanation_mistakes(data)
    for i, entry in enumerate(_entries(data, "override", found)):
        found += _override_mistakes(entry, f"override[{i}]")
    found += [f"{name} is missing" for name in ("run.py",) if not (folder / name).is_file()]
    if not any((folder / name).is_file() for name in ("reference.csv", "reference.py")):
        found.append("reference.csv or reference.py is missing: expected values need a source")
    return found


def _explanation_mistakes(data: Mapping[str, Any]) -> list[str]:
    """A disagreement is explained in words and pinned by numbers, or it is not explained."""
    found: list[str] = []
    verdict = data.get("expected_verdict", "agrees")
    entries = _entries(data, "explained", found)
    if verdict not in EXPECTED_VERDICTS:
        allowed = ", ".join(EXPECTED_VERDICTS)
        found.append(f"expected_verdict = {verdict!r}: must be one of {allowed}")
    if verdict == "disagrees-explained":
        if not _is_text(data.get("explanation", "")):
            found.append("explanation is missing: a disagreement needs a written why")
        if not entries:
            found.append("explained is missing: record the number that disagrees for each row")
    elif "explanation" in data or entries:
        found.append("explanation, explained: only with expected_verdict = 'disagrees-explained'")
    for i, entry in enumerate(entries):
        where = f"explained[{i}]"
        found += _key_mistakes(
            entry, where, ("quantity", "got", "within"), ("quantity", "explanation")
        )
        if "got" in entry and not _is_number(entry["got"]):
            found.append(f"{where}.got = {entry['got']!r}: must be a finite number")
        if "within" in entry and not _is_number(entry["within"], least=0.0):
            found.append(f"{where}.within = {entry['within']!r}: must be a finite number >= 0")
    return found


def _override_mistakes(entry: Mapping[str, Any], where: str) -> list[str]:
    texts = ("quantity", "tolerance_reason")
    found = _key_mistakes(entry, where, (*texts, "tolerance"), (*texts, "metric"))
    if "tolerance" in entry and not _is_number(entry["tolerance"], least=0.0):
        found.append(f"{where}.tolerance = {entry['tolerance']!r}: must be a finite number >= 0")
    if entry.get("metric", "value") not in METRICS:
        found.append(f"{where}.metric = {entry['metric']!r}: must be one of {', '.join(METRICS)}")
    return found


def _key_mistakes(
    entry: Mapping[str, Any], where: str, required: tuple[str, ...], texts: tuple[str, ...]
) -> list[str]:
    found = [f"{where}.{key} is missing" for key in required if key not in entry]
    found += [f"{where}: unknown key {key!r}" for key in entry if key not in {*required, *texts}]
    for key in texts:
        if key in entry and not _is_text(entry[key]):
            found.append(f"{where}.{key} = {entry[key]!r}: must be a text that says something")
    return found


def _entries(data: Mapping[str, Any], key: str, found: list[str]) -> list[Mapping[str, Any]]:
    entries = data.get(key, [])
    if isinstance(entries, list) and all(isinstance(entry, dict) for entry in entries):
        return entries
    found.append(f"{key} = {entries!r}: must be tables, [[{key}]]")
    return []


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and len(value.strip()) >= 3


def _is_number(value: Any, least: float = -math.inf) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return math.isfinite(value) and value >= least
