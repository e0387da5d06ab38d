"""The closed-form steady state beside the collocation."""

import beltsim
from beltsim.model import chain
from validation.cross_method.steady_state.reference import solve
from validation.row import Row, gathered

NAMES = ("p", "theta_t", "w*_1(1)")


def compute() -> list[Row]:
    rows = []
    for epsilon in (0.01, 0.05, 0.1, 0.2):
        drive = beltsim.presets.zhu_parker_2008(epsilon=epsilon)
        for Omega in (0.0, 6.3, 12.0):
            state = chain(drive, Omega, n_functions=1).system.state
            ours = (state.p[0], state.theta_t, state.w_1[0])
            rows += list(map(Row, NAMES, ours, solve(epsilon, Omega)))
    return gathered(rows)
