"""The operating range in crank speed."""

import beltsim
from validation.reference import printed


def compute() -> list[tuple[str, float, float]]:
    rpm = beltsim.presets.zhu_parker_2008().rpm(12.0)
    return [("crank speed at Omega = 12, rpm", rpm, printed(__file__)["5880 rpm"])]
