"""A bar on a terminal for what takes longer than two seconds.

Depends on: tqdm, and only where a bar may be seen.
"""

from __future__ import annotations

import shutil
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Seconds before a bar appears.
PATIENCE_S = 2.0


@contextmanager
def patience(what: str) -> Iterator[None]:
    """A line on a terminal for a wait without a known end, when it takes longer than that."""
    if not sys.stderr.isatty():
        yield
        return
    late = threading.Timer(PATIENCE_S, print, (what,), {"file": sys.stderr, "flush": True})
    late.daemon = True
    late.start()
    try:
        yield
    finally:
        late.cancel()


@contextmanager
def progress(what: str) -> Iterator[Callable[[float], None] | None]:
    """A function that takes the share done, 0 to 1; None where standard error is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    layout = "{desc} {percentage:3.0f} % |{bar}| {elapsed}, {remaining} to go"
    size = shutil.get_terminal_size()  # 80 x 24 where the terminal does not tell
    with tqdm(
        total=1.0,
        desc=what,
        bar_format=layout,
        ncols=min(72, size.columns - 1),
        nrows=size.lines,
        delay=PATIENCE_S,
        leave=False,
        file=sys.stderr,
    ) as bar:
        yield lambda share: _move(bar, share)


def _move(bar: object, share: float) -> None:
    bar.update(share - bar.n)  # type: ignore[attr-defined]
