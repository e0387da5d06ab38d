"""All results as one page of HTML: no scripts, nothing loaded from elsewhere.

Depends on: compare, pictures, table; jinja2, matplotlib.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from validation.compare import VERDICTS, Result
from validation.table import as_data

TEMPLATE = Path(__file__).with_name("page.html")


def html(results: Sequence[Result], seconds: float, version: str) -> str:
    """The page.

    Raises
    ------
    ModuleNotFoundError
        Without jinja2.
    """
    import jinja2  # only for who wants the page
    from markupsafe import Markup

    from validation import pictures  # loads matplotlib

    drawn = [pictures.of_case(result) for result in results]
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    data: dict[str, Any] = as_data(results, seconds, version)
    rows = [row for result in results for row in result.rows]
    return template.render(
        run=data,
        counts=[(v, sum(r.verdict == v for r in results)) for v in VERDICTS],
        row_counts=[(v, sum(row.verdict == v for row in rows)) for v in VERDICTS],
        pictures=[[Markup(svg) for svg in shown] for shown, _ in drawn],
        left_out=[count for _, count in drawn],
        explained=[[e for e in result.case.explained if e.explanation] for result in results],
        overrides=[result.case.overrides for result in results],
    )
