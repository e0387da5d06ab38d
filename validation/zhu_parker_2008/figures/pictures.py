"""Pictures of the figures' datasets, by name of the file.

Solid: event map, short series; dashed: event map, converged; dotted: harmonic balance as in the
paper, short series.

Depends on: beltsim.plots; validation.zhu_parker_2008.figures.
"""

from __future__ import annotations

from typing import Any

from beltsim import plots
from validation.zhu_parker_2008.figures import A_3

#: What is drawn of the four computations, in the order of the dashes.
DRAWN = [
    "event map, N = (4, 5, 5)",
    "event map, converged",
    "harmonic balance, N = (4, 5, 5)",
]
ENERGY = r"dissipated energy $\Delta E$ ($P_0 r_t$)"
TURNING = {"theta_t": "arm", "theta_2": "pulley 2", "theta_3": "pulley 3"}


def pictures(name: str, data: Any) -> dict[str, Any]:
    """Figures to draw of the dataset of figure `name`, by file name without suffix."""
    if name != "fig10":
        data = data.sel(computation=DRAWN)
    drawn: dict[str, Any] = _PICTURES[name](name, data)
    return drawn


def _speeds(panels: dict[str, Any], title: str) -> Any:
    return plots.curves(panels, "Omega", "Q_m", "computation", title=title)


def _turning(data: Any) -> dict[str, Any]:
    return {f"rms, {word} (rad)": data.rms.sel(coordinate=key) for key, word in TURNING.items()}


def _fig03(name: str, data: Any) -> dict[str, Any]:
    return {name: _speeds(_turning(data), "Fig. 3: arm and pulleys over speed")}


def _spans(values: Any, label: str) -> dict[str, Any]:
    return {f"{label}, span {int(i)}": values.sel(span=i) for i in values.span}


def _fig04(name: str, data: Any) -> dict[str, Any]:
    panels = _spans(data.span_rms, "rms (span lengths)")
    return {name: _speeds(panels, "Fig. 4: transverse motion averaged along the spans")}


def _fig05(name: str, data: Any) -> dict[str, Any]:
    panel = {"rms of $a_3$, span 1 (span lengths)": data.rms.sel(coordinate=A_3)}
    spectra = data.amplitude.sel(Q_m=0.5, signal=A_3, harmonic=[0, 1, 3, 5, 7, 9])
    near = spectra.sel(Omega=slice(2.5, 7.0))
    names = DRAWN if near.sizes["Omega"] else []
    falls = {key: near.sel(computation=key) for key in names[:2]}
    found = {f"{name}a": _speeds(panel, "Fig. 5(a): third sine of span 1")}
    if falls:
        title = "Fig. 5(b): spectra of $a_3$ of span 1, $Q_m$ = 0.5"
        found[f"{name}b"] = plots.waterfall(falls, "amplitude (span lengths)", title)
        panels = {
            f"harmonic {k} of $a_3$": data.amplitude.sel(signal=A_3, harmonic=k, Q_m=0.5)
            for k in (1, 3, 5)
        }
        title = "Harmonics of $a_3$ of span 1, $Q_m$ = 0.5 (span lengths)"
        found[f"{name}c"] = plots.curves(
            panels, "Omega", None, "computation", title=title, log=True
        )
    return found


def _fig06(name: str, data: Any) -> dict[str, Any]:
    title = "Fig. 6: arm and pulleys over the friction torque"
    return {name: plots.curves(_turning(data), "Q_m", "Omega", "computation", title=title)}


def _fig07(name: str, data: Any) -> dict[str, Any]:
    return {name: _speeds({ENERGY: data.dissipated_energy}, "Fig. 7: dissipated energy over speed")}


def _fig08(name: str, data: Any) -> dict[str, Any]:
    panel = {ENERGY: data.dissipated_energy}
    title = "Fig. 8: dissipated energy over the friction torque"
    return {name: plots.curves(panel, "Q_m", "Omega", "computation", title=title)}


def _fig09(name: str, data: Any) -> dict[str, Any]:
    title = r"Fig. 9: arm velocity and friction torque at $\Omega$ = 6.3"
    return {name: plots.arm_histories(data.rename(computation="solver"), title)}


def _fig10(name: str, data: Any) -> dict[str, Any]:
    panel = {"critical torque $Q_{cr}$ ($P_0 r_t$)": data.Q_cr}
    title = "Fig. 10: torque that locks the arm"
    return {name: plots.curves(panel, "Omega", "epsilon", "computation", title=title)}


def _fig11(name: str, data: Any) -> dict[str, Any]:
    panels = _spans(data.peak_dynamic_tension, "largest $|P_d|$ ($P_0$)")
    return {name: _speeds(panels, "Fig. 11: largest dynamic tension of each span")}


_PICTURES = {
    "fig03": _fig03,
    "fig04": _fig04,
    "fig05": _fig05,
    "fig06": _fig06,
    "fig07": _fig07,
    "fig08": _fig08,
    "fig09": _fig09,
    "fig10": _fig10,
    "fig11": _fig11,
}
