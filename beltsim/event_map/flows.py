r"""The two linear flows between events, in their modes.

Between events the state x = (q, q_dot) is

.. math::
   x(t) = \mathrm{Re}\,V e^{\Lambda t} a + \mathrm{Re}\sum_h P_h e^{ih\Omega t} + X_c c,
   \qquad a = W\,(x - \text{forced part}),

with `V` the eigenvectors of one of each conjugate pair. *Free joint*: all n coordinates, `c` is
the friction torque. *Held joint*: the n - 1 others, `c` is the position at which the joint is held.
Each flow carries the signal that ends its phases: the joint's velocity, or the reaction

.. math:: H_R = f_t - (M_{tq}\ddot q + (C + G)_{tq}\dot q + K_{tq} q + K_{tt} q_t),

with :math:`\ddot q` from the other rows at zero velocity and acceleration of the joint.
The saturated law has instead a flow *inside its band*, with `Q_m/sigma` added to the
joint's damping.

A flow whose eigenvectors are too ill-conditioned, or which has an exponent at a harmonic of the
forcing or at zero, comes in cells instead (`cells.CellFlow`).

Depends on: cells, linear_part, binding, status, problem, friction, checks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.cells import CellFlow
from beltsim.event_map.linear_part import ComplexArray, LinearPart
from beltsim.event_map.status import require_ok
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem

#: Largest condition number of an eigenvalue with which modes are trusted. Near critical damping the
#: error of event times was measured as 1e-18 T times it, of energies as 2e-18 times its square.
#: Belt drives have 2.4, random problems 10.
CONDITION_LIMIT = 1e3
#: Smallest distance of an exponent from 0 and from the forcing's harmonics, over Omega: the forced
#: part grows with its inverse and is subtracted again.
RESONANCE_LIMIT = 1e-4
#: Condition of K below which the response to a constant load is well defined.
SOUND_STIFFNESS = 1e8
#: Phases of a flow: joint free, held, inside the band.
FREE, HELD, BAND = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Flow:
    """One linear flow of N reals with m amplitudes; see the module for the symbols.

    `packed` holds all arrays in the order in which the C map reads them, and its tables.
    `condition` is the worst of the eigenvalues'.
    """

    part: LinearPart
    packed: FloatArray
    m: int
    condition: float

    @cached_property
    def _parts(self) -> tuple[FloatArray, ...]:
        """The packed arrays, in their order."""
        N, m, H1 = self.N, self.m, len(self.part.D)
        sizes = [m, m, m * N, m * N, N * m, N * m, H1 * N, H1 * N, N]
        return tuple(np.split(self.packed, np.cumsum(sizes)))

    def _complex(self, i: int) -> ComplexArray:
        found: ComplexArray = self._parts[i] + 1j * self._parts[i + 1]
        return found

    @cached_property
    def exponents(self) -> ComplexArray:
        """One of each conjugate pair (m,)."""
        return self._complex(0)

    @cached_property
    def V(self) -> ComplexArray:
        """Amplitudes to state (N, m)."""
        return self._complex(2).reshape(self.m, self.N).T

    @cached_property
    def W(self) -> ComplexArray:
        """State to amplitudes (m, N)."""
        return self._complex(4).reshape(self.N, self.m).T

    @cached_property
    def P(self) -> ComplexArray:
        """Forced response (H + 1, N)."""
        return self._complex(6).reshape(len(self.part.D), self.N)

    @cached_property
    def X_c(self) -> FloatArray:
        """Response (N,) to a unit constant load."""
        return self._parts[8]

    @property
    def Omega(self) -> float:
        """Fundamental of the forcing."""
        return self.part.Omega

    @cached_property
    def fastest(self) -> float:
        """Largest modulus of an exponent."""
        return float(np.abs(self.exponents).max(initial=0.0))

    @property
    def N(self) -> int:
        """Reals in the state."""
        return len(self.part.row)


AnyFlow = Flow | CellFlow


@dataclass(frozen=True, eq=False)
class Flows:
    """Free and held flow of one linear system, and how they meet at an event.

    `m_t` (n - 1,) = M_qq^-1 M_qt, `mass` = M_tt - M_tq m_t the joint's mass with the rest free to
    move, `push` (n,) = M^-1 e_t, `rest` the 2n - 2 indices of the state without the joint.
    """

    free: AnyFlow
    held: AnyFlow
    m_t: FloatArray
    mass: float
    push: FloatArray
    rest: NDArray[np.intp]


def flows_of(problem: FrictionProblem) -> Flows:
    """Flows of `problem`, computed once per linear system and shared by all torques on it."""
    cache = problem.shared
    if "event_map.flows" not in cache:
        cache["event_map.flows"] = _flows(problem)
    found: Flows = cache["event_map.flows"]
    return found


def inner_flow(problem: FrictionProblem) -> AnyFlow:
    """The flow that takes the place of stick: held joint, or inside the band."""
    law = problem.friction
    if not isinstance(law, SaturatedCoulomb):
        return flows_of(problem).held
    cached = problem.shared.get("event_map.band")
    if cached is None or cached[0] != law:
        cached = (law, _band(problem, law))
        problem.shared["event_map.band"] = cached
    found: AnyFlow = cached[1]
    return found


def roles_of(problem: FrictionProblem) -> tuple[tuple[int, AnyFlow], tuple[int, AnyFlow]]:
    """The two flows of a motion, with what the C map calls their phases."""
    role = BAND if isinstance(problem.friction, SaturatedCoulomb) else HELD
    return (FREE, flows_of(problem).free), (role, inner_flow(problem))


def _band(problem: FrictionProblem, law: SaturatedCoulomb) -> AnyFlow:
    n, j = problem.n, problem.joint
    assert j is not None
    D, F = problem.C + problem.G, problem.forcing.coefficients
    D[j, j] += law.Q_m / law.sigma
    velocity = np.eye(2 * n)[n + j]
    direct = np.zeros(len(F), complex)
    return _flow(
        problem.M, D, problem.K, F, problem.forcing.Omega, np.zeros(n), velocity, direct, 0.0
    )


def _flows(problem: FrictionProblem) -> Flows:
    n, j, o = problem.n, problem.joint, problem.others
    assert j is not None
    D, F = problem.C + problem.G, problem.forcing.coefficients
    Omega = problem.forcing.Omega
    unit = np.eye(n)[j]
    M_qq, K_qq = problem.block("M", "q", "q"), problem.block("K", "q", "q")
    D_qq = D[np.ix_(o, o)]
    m_t = np.linalg.solve(M_qq, problem.M[o, j])
    velocity = np.eye(2 * n)[n + j]
    free = _flow(problem.M, D, problem.K, F, Omega, -unit, velocity, np.zeros(len(F), complex), 0.0)
    row = np.concatenate([m_t @ K_qq - problem.K[j, o], m_t @ D_qq - D[j, o]])
    direct = F[:, j] - F[:, o] @ m_t
    d_c = float(m_t @ problem.K[o, j] - problem.K[j, j])
    held = _flow(M_qq, D_qq, K_qq, F[:, o], Omega, -problem.K[o, j], row, direct, d_c)
    mass = float(problem.M[j, j] - problem.M[j, o] @ m_t)
    push = np.linalg.solve(problem.M, unit)
    return Flows(free, held, m_t, mass, push, np.concatenate([o, n + o]))


def _flow(
    M: FloatArray,
    D: FloatArray,
    K: FloatArray,
    F: ComplexArray,
    Omega: float,
    load: FloatArray,
    row: FloatArray,
    direct: ComplexArray,
    d_c: float,
) -> AnyFlow:
    """The flow of M q'' + D q' + K q = f + load c, in modes where they can be trusted."""
    part = LinearPart(M, D, K, F, load, Omega, row, direct, d_c)
    n, H = len(M), len(F) - 1
    packed = np.empty(binding.flow_reals(2 * n, 2 * n, H)[1])
    system = (M, D, K, binding.pairs(F), load, row, binding.pairs(direct), d_c)
    status, m, *sound = binding.modes(n, H, Omega, *system, packed)
    require_ok(status)
    condition, stiffness, near, near_mean = sound
    # Slow modes of a sound K are creep, as in a narrow band, and no resonance with the mean.
    near = near if stiffness < SOUND_STIFFNESS else min(near, near_mean)
    if not condition <= CONDITION_LIMIT or near < RESONANCE_LIMIT:
        return CellFlow(part, packed[:m] + 1j * packed[m : 2 * m], condition, _energy(part))
    return Flow(part, packed[: binding.flow_reals(2 * n, m, H)[1]], m, condition)


def _energy(part: LinearPart) -> tuple[FloatArray, FloatArray]:
    """State to coordinates whose squares are energies, and back; K is lifted where it must be."""
    n = len(part.M)
    into = np.zeros((2 * n, 2 * n))
    if n:
        root = np.linalg.cholesky(part.M)
        inverse = np.linalg.inv(root)
        squares, turn = np.linalg.eigh(inverse @ part.K @ inverse.T)
        floor = part.Omega**2
        into[:n, :n] = (np.sqrt(np.maximum(np.abs(squares), floor))[:, None] * turn.T) @ root.T
        into[n:, n:] = turn.T @ root.T
    return into, np.asarray(np.linalg.inv(into), dtype=float)
