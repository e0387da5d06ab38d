"""Critical torques at three span resonances."""

from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, critical_torque

CANDIDATES = (5.7, 6.3, 8.0)


def compute() -> list[tuple[str, float, float]]:
    expected = printed(__file__)["largest"]
    return [
        (
            f"of 5.7, 6.3, 8.0, {s}",
            max(CANDIDATES, key=lambda x, s=s: critical_torque(x, s)),
            expected,
        )
        for s in SERIES
    ]
