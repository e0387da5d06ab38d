r"""Force of the belt on each pulley, steady and dynamic, in the user's frame.

.. math:: F_j = T_j u_j + V_j(0) v_j - T_{j-1} u_{j-1} - V_{j-1}(1) v_{j-1}

In the steady state V_i = T_i g_i. For the vibration, T becomes P_di and V is recovered weakly from
the span's balance of momentum tested with 1-x and x (u: dynamic deflection), never from the
differentiated sine series:

.. math::
    V_i(0) &= T [u]_0^1 + P_d [w^*]_0^1 - \int (1-x)(\mu u_{tt} - 2\sigma u_{xt}) + \sigma u_t(0) \\
    V_i(1) &= T [u]_0^1 + P_d [w^*]_0^1 + \int x (\mu u_{tt} - 2\sigma u_{xt}) + \sigma u_t(1)

Forces are in units of P0, x to the right and y up as in the drive file; `newtons` converts.
Directions come from the coordinates even where a drive overrides its span lengths and angles.

Depends on: model, response and problem (types only), checks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.model.crank import DrivenSystem
from beltsim.model.galerkin import LinearSystem
from beltsim.model.scaling import DimensionlessDrive
from beltsim.model.steady_state import SteadyState

if TYPE_CHECKING:
    from beltsim.response import Response


@dataclass(frozen=True, eq=False)
class HubLoadRows:
    """Dynamic hub loads as linear functions of the motion; user's pulleys and coordinates.

    F(t) = stiffness q + velocity q' + mass q'' + what follows the crank directly, all (np, 2).

    Parameters
    ----------
    stiffness, velocity, mass : (np, 2, n)
    crank : (H + 1, np, 2) complex
        Harmonics of the part that follows the crank, over `fundamental`.
    fundamental : float
    """

    stiffness: FloatArray
    velocity: FloatArray
    mass: FloatArray
    crank: NDArray[np.complex128]
    fundamental: float


def steady_hub_loads(state: SteadyState) -> FloatArray:
    """Steady force of the belt on each of the user's pulleys: array (np, 2), in P0.

    Parameters
    ----------
    state : SteadyState

    Examples
    --------
    >>> import beltsim
    >>> state = beltsim.model.chain(beltsim.presets.zhu_parker_2008(), 6.3).system.state
    >>> bool(abs(steady_hub_loads(state).sum(axis=0)).max() < 1e-12)
    True
    """
    along = state.T[:, None]
    across = (state.T * state.g)[:, None]
    return _user_forces(state.drive, _forces(state.drive, along, across, across))[:, :, 0]


def hub_load_rows(driven: DrivenSystem) -> HubLoadRows:
    """Dynamic hub loads per coordinate, velocity and acceleration.

    Parameters
    ----------
    driven : DrivenSystem
        From `beltsim.model.chain`.
    """
    system, found = driven.system, driven.coordinates
    point = system.state.point
    stiffness, velocity, mass = (
        _user_forces(system.drive, _forces(system.drive, *rows)) for rows in _shears(system)
    )
    rate = np.arange(len(point.crank_cos)) * point.fundamental
    angle = point.crank_cos - 1j * point.crank_sin
    c = found.crank
    factor = (
        stiffness[..., c]
        + np.multiply.outer(1j * rate, velocity[..., c])
        - np.multiply.outer(rate**2, mass[..., c])
    )
    return HubLoadRows(
        stiffness=stiffness[..., found.index] * found.sign,
        velocity=velocity[..., found.index] * found.sign,
        mass=mass[..., found.index] * found.sign,
        crank=angle[:, None, None] * factor,
        fundamental=point.fundamental,
    )


def hub_load_harmonics(driven: DrivenSystem, coefficients: Any) -> NDArray[np.complex128]:
    """Harmonics of the dynamic hub loads.

    Parameters
    ----------
    driven : DrivenSystem
    coefficients : (R + 1, n) complex
        q(t) = Re sum_k c_k exp(i k Omega t) of the problem assembled from it.

    Returns
    -------
    (max(R, H) + 1, np, 2) complex
        In P0.
    """
    rows, c = hub_load_rows(driven), np.asarray(coefficients, dtype=complex)
    found = np.zeros((max(len(c), len(rows.crank)), *rows.crank.shape[1:]), dtype=complex)
    found[: len(rows.crank)] += rows.crank
    for k, row in enumerate(c):
        rate = k * rows.fundamental
        found[k] += (rows.stiffness + 1j * rate * rows.velocity - rate**2 * rows.mass) @ row
    return found


def dynamic_hub_loads(driven: DrivenSystem, response: Response) -> FloatArray:
    """Dynamic hub loads at the samples of a response.

    Accelerations follow from the equations of motion with the response's own friction torque.

    Parameters
    ----------
    driven : DrivenSystem
        The one that the response's problem was assembled from.
    response : Response

    Returns
    -------
    (nt, np, 2)
        In P0; add `steady_hub_loads` for the total.
    """
    problem, rows = response.problem, hub_load_rows(driven)
    force = problem.forcing.at(response.t)
    if problem.joint is not None:
        force[:, problem.joint] -= response.friction_torque
    force -= response.q_dot @ (problem.C + problem.G).T + response.q @ problem.K
    q_ddot = np.linalg.solve(problem.M, force.T).T
    turns = np.multiply.outer(response.t * rows.fundamental, np.arange(len(rows.crank)))
    found = np.einsum("tk,kpd->tpd", np.exp(1j * turns), rows.crank).real
    parts = ((rows.stiffness, response.q), (rows.velocity, response.q_dot), (rows.mass, q_ddot))
    for factor, motion in parts:
        found += np.einsum("pdn,tn->tpd", factor, motion)
    return np.asarray(found)


def newtons(driven: DrivenSystem | SteadyState, loads: Any) -> Any:
    """Loads in N, from units of P0."""
    return np.asarray(loads) * driven.drive.tension_N


def _forces(
    drive: DimensionlessDrive, along: FloatArray, shear_0: FloatArray, shear_1: FloatArray
) -> FloatArray:
    """Forces (n, 2, m) on the canonical pulleys, for spans' tensions and shears (n, m)."""
    u, v = drive.direction[:, :, None], drive.normal[:, :, None]
    start = along[:, None, :] * u + shear_0[:, None, :] * v
    end = along[:, None, :] * u + shear_1[:, None, :] * v
    return np.asarray(start - np.roll(end, 1, axis=0))


def _user_forces(drive: DimensionlessDrive, forces: FloatArray) -> FloatArray:
    """Canonical forces (n, 2, m) in the user's order and view."""
    found = forces[drive.frame.pulleys]
    found[:, 1] *= drive.frame.sign
    return found


def _shears(system: LinearSystem) -> tuple[tuple[FloatArray, FloatArray, FloatArray], ...]:
    """Tension and both shears of each span per coordinate, velocity and acceleration.

    Three triples (along, V(0), V(1)) of arrays (n, m), canonical.
    """
    state, drive, basis = system.state, system.drive, system.basis
    A0, A1 = drive.arm_deflections
    sigma = state.point.s * drive.span_length
    P, i, k = basis.n_sines, basis.span, basis.k
    column = np.arange(P)
    zero = np.zeros_like(system.tension_rows)
    tension = system.tension_rows
    stiff = tension * (state.w_1 - state.w_0)[:, None]
    # moments of the sines and of their slopes with 1-x ("start") and x ("end")
    odd = np.where(k % 2 == 1, 2.0, 0.0)
    slope = odd / (np.pi * k)
    velocity_0, velocity_1, mass_0, mass_1 = (zero.copy() for _ in range(4))
    velocity_0[i, column] = 2.0 * sigma[i] * slope
    velocity_1[i, column] = 2.0 * sigma[i] * slope
    mass_0[i, column] = -drive.mu[i] / (np.pi * k)
    mass_1[i, column] = drive.mu[i] * (odd - 1.0) / (np.pi * k)
    if drive.arm is not None:
        stiff[:, -1] += state.T * drive.arm_chord
        velocity_0[:, -1] = sigma * (drive.arm_chord + A0)
        velocity_1[:, -1] = sigma * (A1 - drive.arm_chord)
        mass_0[:, -1] = -drive.mu * (A0 / 3.0 + A1 / 6.0)
        mass_1[:, -1] = drive.mu * (A0 / 6.0 + A1 / 3.0)
    return (tension, stiff, stiff), (zero, velocity_0, velocity_1), (zero, mass_0, mass_1)
