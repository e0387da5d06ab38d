"""One friction problem through every solver, and a judge that shares no code with any of them.

Compared are what users read off a steady motion: rms of every coordinate, extremes of every
observable (span tensions), dissipated energy, stick fraction, event times, velocity reversals.
Each motion is also put back into the equations and the friction law on a fine grid. So when two
solvers differ, the residuals say which of them is wrong.

Depends on: anything but cli.
"""

from beltsim.cross_check.candidates import Candidate, candidates
from beltsim.cross_check.check import Check, Difference, check, compare, require_tolerance
from beltsim.cross_check.motion import Motion, motion_of
from beltsim.cross_check.residuals import Residuals, residuals

__all__ = [
    "Candidate",
    "Check",
    "Difference",
    "Motion",
    "Residuals",
    "candidates",
    "check",
    "compare",
    "motion_of",
    "require_tolerance",
    "residuals",
]
