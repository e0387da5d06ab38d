"""Amplitude of the crank's torque on the arm, for four bending stiffnesses and three speeds."""

import numpy as np

import beltsim
from beltsim.model import chain
from validation.row import Row
from validation.zhu_parker_2008.paper import SERIES, SHORT
from validation.zhu_parker_2008.torque_of_crank_on_arm.reference import amplitude

STIFFNESSES = (0.01, 0.05, 0.1, 0.2)


def compute() -> list[Row]:
    axes = {"x": STIFFNESSES, "x_label": "bending stiffness epsilon", "y_label": "over eq. (27)"}
    rows = []
    for Omega in (0.0, 6.3, 12.0):
        ours = np.array([_amplitude(epsilon, Omega) for epsilon in STIFFNESSES])
        expected = np.array([amplitude(epsilon, Omega) for epsilon in STIFFNESSES])
        rows.append(
            Row(f"over eq. (27), Omega = {Omega}", ours / expected, np.ones(len(ours)), **axes)
        )
        falls = float((np.diff(ours) < 0.0).all())
        rows.append(Row(f"falls with epsilon (1), Omega = {Omega}", falls, 1.0))
    return rows


def _amplitude(epsilon: float, Omega: float) -> float:
    drive = beltsim.presets.zhu_parker_2008(epsilon=epsilon)
    driven = chain(drive, Omega, **SERIES[SHORT])
    return float(np.hypot(driven.cos[1, -1], driven.sin[1, -1]))
