"""Time of `beltsim.assemble`, validation included: python benchmarks/assemble.py

Milliseconds per call on one thread, best and median of many batches, each call at a speed of its
own so that nothing but the drive is reused.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import statistics
import time
from pathlib import Path

import beltsim

CALLS, BATCHES = 5, 60
DRIVES = Path(__file__).parent.parent / "examples"


def batch(drive: beltsim.Drive, n_functions: int) -> float:
    """Milliseconds per call over one batch."""
    start = time.perf_counter()
    for i in range(CALLS):
        beltsim.assemble(drive, drive.Omega + 1e-3 * i, n_functions=n_functions)
    return (time.perf_counter() - start) / CALLS * 1e3


def main() -> None:
    """Print one line per drive and number of sine functions."""
    print(f"{'drive':24} {'N':>3} {'n':>4} {'best ms':>8} {'median ms':>10}")
    for name in ("zhu_parker_2008", "passenger_car_7_pulley"):
        drive = beltsim.load_drive(DRIVES / f"{name}.toml")
        for n_functions in (8, 16):
            n = beltsim.assemble(drive, n_functions=n_functions).n
            times = [batch(drive, n_functions) for _ in range(BATCHES)]
            best, median = min(times), statistics.median(times)
            print(f"{name:24} {n_functions:3} {n:4} {best:8.2f} {median:10.2f}")


if __name__ == "__main__":
    main()
