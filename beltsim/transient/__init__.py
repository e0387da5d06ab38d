r"""Runs in time on SUNDIALS' CVODE, with every stick, reversal and release located.

.. math:: M\ddot q + (C + G)\dot q + K q + e_j h_c(\dot q_j) = f(t)

Between events the system is linear and smooth, and CVODE (Adams or BDF) integrates it in a fixed
mode: ``slip+``, ``slip-`` or ``stick``. The mode changes only at located events:

* slip ends at a zero of the joint's velocity. The reaction that would hold the joint decides: at
  most Q_s, it sticks; otherwise it slips on in the direction of the reaction.
* stick ends where the reaction reaches Q_s. While sticking, the joint stays at the position where
  it stopped and its velocity is exactly zero.

Roots are isolated on the solver's interpolating polynomial over each whole step, so two crossings
inside one step are found too; a minimum that comes close to a threshold without reaching it is
reported in `Response.near_grazing`. Every phase starts with a short local Taylor series, which
knows the order of the zero it starts from.

Samples and the state at the end are interpolated; the solver is never made to stop for output. The
energy balance rests on Gauss quadrature of forcing work and viscous loss on the dense output, over
the last period only.

Depends on: errors, checks, problem, friction, response, and the compiled core `beltsim._core`.
"""

from __future__ import annotations

from beltsim.transient.many import solve_many
from beltsim.transient.run import integrate
from beltsim.transient.settings import Settings

__all__ = ["Settings", "integrate", "solve_many"]
