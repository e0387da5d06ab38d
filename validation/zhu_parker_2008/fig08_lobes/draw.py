"""Pictures of the study, from its stored data.

`python -m validation.zhu_parker_2008.fig08_lobes.draw [--out DIR]` writes them, by default to
docs/figures.

Depends on: data; beltsim.plots.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

from beltsim import plots
from beltsim.plots.style import CYCLE, GREY, INK, new_figure, plain_axes
from validation.zhu_parker_2008.fig08_lobes.data import OMEGA, load

FIGURES = Path(__file__).parents[3] / "docs" / "figures"
ENERGY = r"dissipated energy $\Delta E$ ($P_0 r_t$)"


def fig08() -> Any:
    """Fig. 8 as the paper has it, R = 9 to 13, beside the exact curve; nu below."""
    series, exact = load("fig08"), load("exact").isel(series=0).sel(Omega=OMEGA)
    figure = new_figure(7.6, 6.4)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    chosen = series.sel(Omega=OMEGA, sigma=1e-4)
    for axes in (upper, lower):
        plain_axes(axes)
    for i, R in enumerate((9, 11, 13)):
        one, style = (
            chosen.sel(R=R),
            {"color": CYCLE[i], "linewidth": 1.0, "marker": ".", "markersize": 3},
        )
        upper.plot(one.Q_m, one.dissipated_energy, label=f"series, R = {R}", **style)
        lower.plot(one.Q_m, one.reversals_of_series + 0.04 * (i - 1), **style)
    upper.plot(exact.Q_m, exact.dissipated_energy, color=INK, linewidth=1.8, label="exact")
    lower.plot(exact.Q_m, exact.velocity_reversals, color=INK, linewidth=1.8)
    upper.set_ylabel(ENERGY)
    lower.set_ylabel(r"reversals $\nu$")
    lower.set_xlabel(r"friction torque $Q_m$ ($P_0 r_t$)")
    lower.set_xlim(0.0, 12.0)
    upper.legend(frameon=False)
    figure.suptitle(rf"Dissipated energy and velocity reversals at $\Omega$ = {OMEGA}")
    return figure


def lobes() -> Any:
    """What a truncated series adds to the exact dissipated energy: the lobes themselves."""
    series, exact = load("fig08"), load("exact").isel(series=0).sel(Omega=OMEGA)
    chosen = series.sel(Omega=OMEGA, sigma=0.0)
    shown = chosen.dissipated_energy - exact.dissipated_energy.sel(Q_m=chosen.Q_m)
    title = "Dissipated energy of a truncated series less the exact one, set-valued law"
    return plots.curves({r"$\Delta E - \Delta E_{exact}$": shown}, "Q_m", "R", title=title)


def reversals() -> Any:
    """Reversals of the truncated series over (Q_m, R): set-valued and the paper's method."""
    series = load("series").sel(Omega=OMEGA)
    titles = {0.0: "set-valued law"}
    panels = {
        titles.get(sigma, rf"saturated, $\sigma$ = {sigma:.0e}"): series.reversals_of_series.sel(
            sigma=sigma
        )
        for sigma in (0.0, 1e-3, 1e-4, 1e-6)
    }
    return plots.grid_map(
        panels,
        "Q_m",
        "R",
        r"reversals $\nu$ of the series",
        y_label="harmonics R",
        columns=2,
        title="Velocity reversals of the series grow with its length (cross: did not converge)",
    )


def sticking() -> Any:
    """Velocity of the arm in the sticking phase at Q_m = 3.5 and 6.1, zoomed, by each solver."""
    found = load("sticking")
    groups = (
        ("in time", [name for name in found.solver.values if "R =" not in name]),
        ("set-valued series", [name for name in found.solver.values if "set-valued" in name]),
        ("paper's method, $\\sigma$ = 1e-4", [n for n in found.solver.values if "paper" in n]),
    )
    figure = new_figure(7.6, 6.2)
    table = figure.subplots(len(groups), 2, sharey=True, sharex="col")
    for column, Q_m in enumerate(found.Q_m.values.tolist()):
        here = found.sel(Q_m=Q_m)
        low, high = _rest(here)
        for axes, (title, names) in zip(table[:, column], groups, strict=True):
            plain_axes(axes)
            axes.axvspan(low, high, color="#E3E6EA", linewidth=0.0)
            axes.axhline(0.0, color=GREY, linewidth=0.6)
            for i, name in enumerate(names):
                one = here.sel(solver=name)
                if one.velocity.isnull().all():  # did not converge
                    continue
                style = ("-", (0, (4, 3)), (0, (1, 2)), "-")[i % 4 if title == "in time" else 0]
                label = name.replace("set-valued, ", "").replace("paper's method, ", "")
                axes.plot(one.phase, one.velocity, CYCLE[i], linestyle=style, label=label, lw=1.2)
            axes.set_title(f"{title}, $Q_m$ = {Q_m:g}", loc="left", fontsize=10)
            axes.set_xlim(low - 0.35 * (high - low), high + 0.35 * (high - low))
            axes.set_ylim(-0.012, 0.012)
            axes.legend(frameon=False, fontsize=7, ncols=1, loc="lower left")
        table[-1, column].set_xlabel("time over forcing period")
    for axes in table[:, 0]:
        axes.set_ylabel("arm velocity (dim.less)")
    figure.suptitle(
        rf"Velocity of the arm about a stop at $\Omega$ = {OMEGA} (shaded: the exact arm rests)"
    )
    return figure


def _rest(here: Any) -> tuple[float, float]:
    """The first stretch, away from the ends of the period, in which the exact arm rests."""
    rests = np.flatnonzero(here.velocity.sel(solver="event map").values == 0.0)
    runs = np.split(rests, np.flatnonzero(np.diff(rests) > 1) + 1)
    inside = [run for run in runs if run[0] > 0.1 * here.sizes["phase"] and len(run) > 3]
    return float(here.phase[inside[0][0]]), float(here.phase[inside[0][-1]])


def _phases(names: dict[str, str], title: str) -> Any:
    phases = load("maps").phases_per_period
    halves = phases.where(phases != 1.0, 0.0) / 2.0  # an arm at rest has no phases to speak of
    panels = {word: halves.sel(case=name) for name, word in names.items()}
    label = "phases per half period"
    return plots.grid_map(panels, "Omega", "share", label, first=0, title=title)


def phases_N() -> Any:
    """Phases per half period, as the sine series is refined."""
    names = {"N = (4, 5, 5)": "N = (4, 5, 5)", "N = 8": "N = 8", "N = 40": "N = 40"}
    return _phases(names, "Exact motion of the arm: how often it stops")


def phases_damping() -> Any:
    """Phases per half period for less damping."""
    names = {
        "N = (4, 5, 5)": r"$\zeta$ = 5 %",
        "damping 1 %": r"$\zeta$ = 1 %",
        "damping 0.5 %": r"$\zeta$ = 0.5 %",
    }
    return _phases(names, "Exact motion of the arm with less damping, N = (4, 5, 5)")


def phases_static() -> Any:
    """Phases per half period for larger static friction; a cross: no orbit of up to 3 periods."""
    names = {f"Q_s = {k} Q_m": f"$Q_s = {k}\\,Q_m$" for k in ("1.2", "1.5", "2")}
    title = "Exact motion for larger static friction (cross: no orbit of up to 3 periods found)"
    return _phases(names, title)


PICTURES = {
    "lobes-fig08": fig08,
    "lobes-gap": lobes,
    "lobes-reversals": reversals,
    "lobes-sticking": sticking,
    "lobes-phases": phases_N,
    "lobes-damping": phases_damping,
    "lobes-static": phases_static,
}


def main(argv: list[str] | None = None) -> int:
    """Draw the pictures named, or all."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("picture", nargs="*", help=f"of {', '.join(PICTURES)} (default: all)")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder (default: docs/figures)")
    options = parser.parse_args(argv)
    for name in options.picture or PICTURES:
        path = plots.save_figure(PICTURES[name](), options.out / f"{name}.png")
        print(f"{path} {path.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
