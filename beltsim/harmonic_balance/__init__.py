r"""Periodic responses by harmonic balance, condensed onto the friction joint.

.. math:: V_r = A_r(F_r - h_r), \quad r = 1..R, \qquad A_r = i r\Omega/Z_r

Exact Coulomb friction as a set-valued law (no band, converges from a cold start), or with switching
instants from a given pattern (Q_s > Q_m); and the paper's method for the saturated law (alternating
frequency and time, Newton-Raphson). Complex
rows follow :math:`q(t) = \mathrm{Re}\sum_k c_k e^{ik\Omega t}`, row 0 the mean.

Depends on: errors, checks, problem, friction, response; numba in `_kernels` alone.
"""

from __future__ import annotations

from beltsim.harmonic_balance.condensation import condense
from beltsim.harmonic_balance.continuation import Branch, follow, trace
from beltsim.harmonic_balance.many import solve_many
from beltsim.harmonic_balance.pattern import Pattern
from beltsim.harmonic_balance.reversals import reversals_of_series, sign_change_angles
from beltsim.harmonic_balance.settings import Settings
from beltsim.harmonic_balance.solve import solve
from beltsim.harmonic_balance.survey import Survey, survey
from beltsim.harmonic_balance.warm import compile_kernels

__all__ = [
    "Branch",
    "Pattern",
    "Settings",
    "Survey",
    "compile_kernels",
    "condense",
    "follow",
    "reversals_of_series",
    "sign_change_angles",
    "solve",
    "solve_many",
    "survey",
    "trace",
]
