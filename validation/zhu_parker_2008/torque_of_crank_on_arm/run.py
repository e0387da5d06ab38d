"""Amplitude of the crank's torque on the arm, for four bending stiffnesses and three speeds."""

import numpy as np

import beltsim
from beltsim.model import chain
from validation.zhu_parker_2008.paper import SERIES, SHORT
from validation.zhu_parker_2008.torque_of_crank_on_arm.reference import amplitude


def compute() -> list[tuple[str, float, float]]:
    rows = []
    for Omega in (0.0, 6.3, 12.0):
        sizes = []
        for epsilon in (0.01, 0.05, 0.1, 0.2):
            drive = beltsim.presets.zhu_parker_2008(epsilon=epsilon)
            driven = chain(drive, Omega, **SERIES[SHORT])
            sizes.append(float(np.hypot(driven.cos[1, -1], driven.sin[1, -1])))
            where = f"epsilon = {epsilon}, Omega = {Omega}"
            rows.append((where, sizes[-1], amplitude(epsilon, Omega)))
        falls = float(all(np.diff(sizes) < 0.0))
        rows.append((f"falls with epsilon at Omega = {Omega}", falls, 1.0))
    return rows
