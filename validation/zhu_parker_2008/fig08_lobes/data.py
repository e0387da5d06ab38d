"""The data of the study: are the lobes of Fig. 8 motion of the arm, or ripples of a series?

`python -m validation.zhu_parker_2008.fig08_lobes.data [PART ...]` computes the parts named
(default: all) and writes `data/<part>.nc`; without `data/` everything can be made again. Times are
those of one core.

=============  ====================================================================
part           holds
=============  ====================================================================
exact          event map, Coulomb: six speeds, fine grid of torques, both series
time_domain    Omega = 6.3: Coulomb and saturated law, sigma = 1e-3 ... 1e-7, by
               event map and CVODE
series         Omega = 6.3, R = 5 ... 401: set-valued, and sigma = 1e-3 ... 1e-6
fig08          Omega = 6.3, R = 5 to 31: set-valued, and sigma = 1e-4; fine grid
speeds_time    the other five speeds: as time_domain, over Q_m/Q_cr
speeds_series  the other five speeds: as series, R = 5 ... 101
sticking       velocity of the arm over a period at Q_m = 3.5 and 6.1, each solver
maps           phases per period over (Omega, Q_m/Q_cr): N, damping, Q_s > Q_m
=============  ====================================================================

Depends on: beltsim.study, beltsim.io; validation.zhu_parker_2008.paper.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import beltsim
from beltsim import io, study
from validation.zhu_parker_2008.paper import SERIES, SHORT

DATA = Path(__file__).with_name("data")
OMEGA = 6.3
SPEEDS = (2.8, 3.3, 5.7, 6.3, 8.0, 8.7)
OTHERS = (2.8, 3.3, 5.7, 8.0, 8.7)
#: Torques at which the paper names nu, and 8.5.
NAMED = (1.0, 3.5, 6.1, 8.5)
#: Up to above the critical torque at 6.3.
TORQUES = np.unique([*np.arange(0.5, 12.01, 0.5), *NAMED])
FINE = np.round(np.arange(0.05, 12.001, 0.05), 2)
#: Torques over the critical torque, for the other speeds and for maps.
SHARES = np.round(np.arange(0.1, 1.001, 0.1), 1)
MAP_SHARES = np.round(np.arange(0.05, 0.951, 0.05), 2)
BANDS = (1e-3, 1e-4, 1e-5, 1e-6)
TIME_BANDS = (*BANDS, 1e-7)
ORDERS = (5, 7, 9, 11, 13, 15, 21, 31, 51, 101, 201, 401)
SPEEDS_ORDERS = (5, 9, 13, 25, 51, 101)
#: Samples per period of the paper's method, as in the reference computation of the paper's curves.
SAMPLES = 256
#: What is kept of each study.
KEPT = (
    *("dissipated_energy", "velocity_reversals", "reversals_of_series", "phases_per_period"),
    *("stick_fraction", "stops_per_period", "period_multiple", "Q_m", "failure"),
)

Progress = Callable[[float], None] | None


def sweep(Omega: Any, Q_m: Any, method: Any, progress: Progress = None, **options: Any) -> Any:
    """`study.sweep` of the paper's drive in the paper's short series, unless told otherwise."""
    preset = {name: options.pop(name) for name in ("zeta",) if name in options}
    drive = beltsim.presets.zhu_parker_2008(**preset)
    options = {**SERIES[SHORT], **options}
    found = study.sweep(drive, Omega, Q_m, method, progress=progress, **options)
    return compact(found)


def compact(found: Any) -> Any:
    """Only what the page uses, failures cut to their first words."""
    kept = found[[name for name in KEPT if name in found]]
    drop = ("coordinate", "span", "coordinate_si_scale", "coordinate_si_unit", "span_length_m")
    kept = kept.drop_vars([name for name in drop if name in kept.coords])
    short = np.array([text[:60] for text in kept.failure.values.ravel()], dtype=np.str_)
    kept["failure"] = (kept.failure.dims, short.reshape(kept.failure.shape))
    return kept


def filled(found: Any) -> Any:
    """Without the variables that hold nothing."""
    empty = [
        name
        for name, one in found.data_vars.items()
        if bool(one.isnull().all() if one.dtype.kind == "f" else (one == "").all())
    ]
    return found.drop_vars(empty)


def exact(progress: Progress = None) -> Any:
    """Event map, exact law: the paper's six speeds, short series and converged."""
    parts = {
        name: sweep(SPEEDS, FINE, study.EventMap(harmonics=0), progress, **options)
        for name, options in SERIES.items()
    }
    return study.combined(parts, "series")


def time_domain(progress: Progress = None) -> Any:
    """Exact orbits and runs in time at 6.3, for the exact law (sigma = 0) and the saturated one."""
    return _time_domain([OMEGA], TORQUES, progress)


def speeds_time(progress: Progress = None) -> Any:
    """The same at the other speeds, over shares of their critical torque."""
    return _time_domain(OTHERS, SHARES, progress, relative=True)


def _time_domain(Omega: Any, Q_m: Any, progress: Progress, **options: Any) -> Any:
    found = {}
    for name in ("event map", "CVODE"):
        bands = {}
        for sigma in (0.0, *TIME_BANDS):
            method = time_method(name, sigma)
            bands[sigma] = sweep(Omega, Q_m, method, progress, **options)
        found[name] = study.combined(bands, "sigma")
    return study.combined(found, "solver")


def time_method(name: str, sigma: float) -> Any:
    """A method in time; the exact law for sigma = 0."""
    if name == "event map":
        return study.EventMap(sigma=sigma or None, harmonics=0)
    return study.Transient(sigma=sigma or None, periods=150, samples_per_period=1)


def series_method(R: int, sigma: float) -> Any:
    """Harmonic balance: set-valued for sigma = 0, else the paper's method with its ladder."""
    if sigma == 0.0:
        return study.HarmonicBalance(R, samples_per_period=1)
    samples = SAMPLES if 2 * R + 1 <= SAMPLES else None
    return study.HarmonicBalance(R, sigma=sigma, samples=samples, samples_per_period=1)


def series(progress: Progress = None, orders: Any = ORDERS) -> Any:
    """Harmonic balance at Omega = 6.3 over (R, sigma, Q_m); sigma = 0 is the set-valued law."""
    return _series([OMEGA], TORQUES, orders, progress)


def _series(
    Omega: Any, Q_m: Any, orders: Any, progress: Progress, bands: Any = BANDS, **options: Any
) -> Any:
    found = {}
    for R in orders:
        laws = {
            sigma: sweep(Omega, Q_m, series_method(R, sigma), progress, **options)
            for sigma in (0.0, *bands)
        }
        found[R] = study.combined(laws, "sigma")
    return study.combined(found, "R")


def fig08(progress: Progress = None) -> Any:
    """Omega = 6.3 on a fine grid of torques: set-valued, and the paper's method at 1e-4."""
    grid = np.round(np.arange(0.1, 12.001, 0.1), 1)
    return _series([OMEGA], grid, (5, 9, 11, 13, 31), progress, bands=(1e-4,))


def speeds_series(progress: Progress = None) -> Any:
    """Harmonic balance at the other speeds, over shares of their critical torque."""
    return _series(OTHERS, SHARES, SPEEDS_ORDERS, progress, relative=True)


def sticking(progress: Progress = None) -> Any:
    """Velocity and torque of the arm over one period at Q_m = 3.5 and 6.1, by each solver."""
    methods = {
        "event map": study.EventMap(),
        "CVODE": study.Transient(periods=150),
        "event map, sigma = 1e-6": study.EventMap(sigma=1e-6),
        **{f"set-valued, R = {R}": study.HarmonicBalance(R) for R in (9, 13, 51, 401)},
        **{f"paper's method, R = {R}": series_method(R, 1e-4) for R in (9, 11, 13, 51)},
    }
    drive = beltsim.presets.zhu_parker_2008()
    found = {}
    for i, (name, method) in enumerate(methods.items()):
        torques = [3.5, 6.1]
        found[name] = study.histories(drive, OMEGA, torques, method, samples=1200, **SERIES[SHORT])
        if progress is not None:
            progress((i + 1) / len(methods))
    both = study.combined(found, "solver")
    both = both.drop_vars("angle")
    return both.assign({k: both[k].astype("float32") for k in ("velocity", "friction_torque")})


MAPS: dict[str, tuple[dict[str, Any], Any]] = {
    "N = (4, 5, 5)": ({}, study.EventMap(harmonics=0)),
    "N = 8": ({"n_functions": 8}, study.EventMap(harmonics=0)),
    "N = 40": ({"n_functions": 40}, study.EventMap(harmonics=0)),
    "damping 1 %": ({"zeta": 0.01}, study.EventMap(harmonics=0)),
    "damping 0.5 %": ({"zeta": 0.005}, study.EventMap(harmonics=0)),
    "Q_s = 1.2 Q_m": ({}, study.EventMap(static_ratio=1.2, max_multiple=3, harmonics=0)),
    "Q_s = 1.5 Q_m": ({}, study.EventMap(static_ratio=1.5, max_multiple=3, harmonics=0)),
    "Q_s = 2 Q_m": ({}, study.EventMap(static_ratio=2.0, max_multiple=3, harmonics=0)),
}
MAP_SPEEDS = np.round(np.arange(0.2, 12.01, 0.2), 1)


def maps(progress: Progress = None) -> Any:
    """Phases per period of the exact motion over (Omega, Q_m/Q_cr), for each entry of `MAPS`."""
    found = {
        name: sweep(MAP_SPEEDS, MAP_SHARES, method, progress, relative=True, **options)
        for name, (options, method) in MAPS.items()
    }
    both = study.combined(found, "case").drop_vars(["stick_fraction", "stops_per_period"])
    return both.assign({k: both[k].astype("float32") for k in ("dissipated_energy", "Q_m")})


PARTS: dict[str, Callable[[Progress], Any]] = {
    "exact": exact,
    "time_domain": time_domain,
    "series": series,
    "fig08": fig08,
    "speeds_time": speeds_time,
    "speeds_series": speeds_series,
    "sticking": sticking,
    "maps": maps,
}


def load(part: str) -> Any:
    """The stored dataset of a part, in memory."""
    import xarray

    with xarray.open_dataset(DATA / f"{part}.nc") as data:
        return data.load()


def _progress(name: str) -> Progress:
    """Share done of the sweep at hand, on a terminal."""
    if not sys.stderr.isatty():
        return None
    return lambda share: print(f"\r{name} {share:4.0%} ", end="", file=sys.stderr)


def main(argv: list[str] | None = None) -> int:
    """Compute and write the parts named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("part", nargs="*", help=f"one of {', '.join(PARTS)} (default: all)")
    chosen = parser.parse_args(argv).part or list(PARTS)
    unknown = [name for name in chosen if name not in PARTS]
    if unknown:
        print(f"unknown part {unknown[0]!r}; known: {', '.join(PARTS)}", file=sys.stderr)
        return 2
    DATA.mkdir(exist_ok=True)
    for name in chosen:
        found = filled(PARTS[name](_progress(name)))
        size = io.save_dataset(found, DATA / f"{name}.nc").stat().st_size
        print(f"data/{name}.nc: {size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
