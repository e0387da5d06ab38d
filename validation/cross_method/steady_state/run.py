"""The closed-form steady state beside the collocation."""

import numpy as np

import beltsim
from beltsim.model import chain
from validation.cross_method.steady_state.reference import solve
from validation.row import Row

NAMES = ("p", "theta_t", "w*_1(1)")
SPEEDS = (0.0, 6.3, 12.0)


def compute() -> list[Row]:
    rows = []
    for epsilon in (0.01, 0.05, 0.1, 0.2):
        drive = beltsim.presets.zhu_parker_2008(epsilon=epsilon)
        states = [chain(drive, Omega, n_functions=1).system.state for Omega in SPEEDS]
        ours = np.array([(state.p[0], state.theta_t, state.w_1[0]) for state in states])
        theirs = np.array([solve(epsilon, Omega) for Omega in SPEEDS])
        for i, name in enumerate(NAMES):
            where = f"{name}, epsilon = {epsilon}, Omega = 0, 6.3, 12"
            rows.append(Row(where, ours[:, i], theirs[:, i], x=SPEEDS))
    return rows
