"""Sign of w*_1(1), from standstill to full speed."""

import numpy as np

import beltsim
from beltsim.model import chain
from validation.reference import printed


def compute() -> list[tuple[str, int, float]]:
    expected = printed(__file__)
    layout = beltsim.presets.zhu_parker_2008().layout
    rows = [("cos(beta_1)", int(np.cos(layout.beta_1) < 0.0), expected["cos(beta_1)"])]
    for epsilon in (0.01, 0.05, 0.1, 0.2):
        drive = beltsim.presets.zhu_parker_2008(epsilon=epsilon)
        for Omega in (0.0, 6.3, 12.0):
            deflection = chain(drive, Omega, n_functions=1).system.state.w_1[0]
            name = f"w*_1(1) at epsilon = {epsilon}, Omega = {Omega}"
            rows.append((name, int(deflection < 0.0), expected["w*_1(1)"]))
    return rows
