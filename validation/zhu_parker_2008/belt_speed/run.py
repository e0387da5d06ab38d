"""Belt speed follows the crank."""

import beltsim
from beltsim.model import chain
from validation.reference import printed


def compute() -> list[tuple[str, float, float]]:
    drive = beltsim.presets.zhu_parker_2008()
    rows = []
    for Omega, expected in printed(__file__).items():
        point = chain(drive, float(Omega), n_functions=1).system.state.point
        rows.append((f"s at Omega = {Omega}", point.s, expected))
    return rows
