"""`python -m validation.zhu_parker_2008.figures [fig03 ...] --out DIR`: datasets and pictures.

Depends on: beltsim.io, beltsim.plots; validation.zhu_parker_2008.figures.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from beltsim import io, plots
from validation.zhu_parker_2008.figures import FIGURES
from validation.zhu_parker_2008.figures.pictures import pictures


def main(argv: list[str] | None = None) -> int:
    """Compute, write and draw the figures named; the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m validation.zhu_parker_2008.figures",
        description="Figures 3 to 11 of Zhu & Parker (2008) as netCDF datasets and pictures.",
    )
    parser.add_argument("figure", nargs="*", help=f"of {', '.join(FIGURES)} (default: all)")
    parser.add_argument("--out", type=Path, default=Path("beltsim-out"), help="folder")
    options = parser.parse_args(argv)
    unknown = [name for name in options.figure if name not in FIGURES]
    if unknown:
        print(f"no figure {unknown[0]!r}; there are {', '.join(FIGURES)}", file=sys.stderr)
        return 2
    io.require_writable(options.out)
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.figure or FIGURES:
        data = FIGURES[name](progress=_progress(name))
        written = [io.save_dataset(data, options.out / f"{name}.nc")]
        for stem, figure in pictures(name, data).items():
            written.append(plots.save_figure(figure, options.out / f"{stem}.png"))
        failed = int((data.failure != "").sum())
        print(
            f"{name}: {', '.join(map(str, written))}; {failed} of {data.failure.size} points failed"
        )
    return 0


def _progress(name: str):  # noqa: ANN202 - a function, or None
    """Share done of the computation at hand, on a terminal."""
    if not sys.stderr.isatty():
        return None
    return lambda share: print(f"\r{name} {share:4.0%} ", end="", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
