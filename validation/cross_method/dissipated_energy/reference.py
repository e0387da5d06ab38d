"""Dissipated energy and stops of the last of many periods, from the exact motion.

No import from beltsim.
"""

from typing import Any

import numpy as np

from validation.cross_method import exact_modal


def energy(problem: Any, periods: int) -> tuple[float, int]:
    """Q_m times the arm's travel, and the number of stops, in the last period."""
    run = exact_modal.run(problem, periods)
    period = 2.0 * np.pi / problem.forcing.Omega
    stops = run.last_period(period, periods * period).count("stick")
    return float(problem.friction.Q_m * run.travel[-1]), stops
