"""nu at the paper's three torques, by solvers in time and by series of several lengths."""

import beltsim
from beltsim import study
from validation.reference import printed
from validation.zhu_parker_2008.fig08_lobes.data import OMEGA, series_method
from validation.zhu_parker_2008.paper import SERIES, SHORT

METHODS = {
    "R = 11": series_method(11, 1e-4),
    "event map": study.EventMap(harmonics=0),
    "CVODE": study.Transient(periods=100, samples_per_period=1),
    "event map, saturated, sigma = 1e-6": study.EventMap(sigma=1e-6, harmonics=0),
    "R = 5": series_method(5, 1e-4),
    "set-valued, R = 101": series_method(101, 0.0),
}


def compute() -> list[tuple[str, float, float]]:
    expected, drive, rows = printed(__file__), beltsim.presets.zhu_parker_2008(), []
    torques = [float(name) for name in expected]
    for name, method in METHODS.items():
        found = study.sweep(drive, [OMEGA], torques, method, **SERIES[SHORT])
        counts = found.reversals_of_series if "R =" in name else found.velocity_reversals
        for Q_m, count, printed_count in zip(
            torques, counts.values[0], expected.values(), strict=True
        ):
            rows.append((f"Q_m = {Q_m}, {name}", float(count), printed_count))
    return rows
