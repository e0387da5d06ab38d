"""Multipliers of three orbits."""

import numpy as np

from beltsim import Coulomb, event_map
from validation.cross_method.floquet_multipliers.reference import moduli
from validation.row import Row
from validation.zhu_parker_2008.paper import problem

LAWS = {
    "Q_m = 1.0": Coulomb(1.0),
    "Q_m = 3.5": Coulomb(3.5),
    "Q_m = 3.5, Q_s = 4.5": Coulomb(3.5, 4.5),
}


def compute() -> list[Row]:
    rows = []
    for name, law in LAWS.items():
        at = problem(6.3).with_friction(law)
        orbit = event_map.periodic(at)
        ours = np.sort(np.abs(orbit.multipliers))
        number = np.arange(1, len(ours) + 1)
        expected = moduli(at, orbit.initial_state)
        axes = "number, by rising modulus", "modulus of the multiplier"
        rows.append(Row(f"multipliers, {name}", ours, expected, number, *axes))
    return rows
