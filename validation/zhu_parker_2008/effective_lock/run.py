"""Critical torque at the exact resonance of span 1."""

from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, by_kind, critical_torque


def compute() -> list[tuple[str, float, float]]:
    expected = printed(__file__)["10.4"]
    rows = []
    for series in SERIES:
        Omega = by_kind(series, 6.0, 6.5)["span 1"][0].Omega
        got = critical_torque(Omega, series)
        rows.append((f"Q_cr at the resonance of span 1, {series}", got, expected))
    return rows
