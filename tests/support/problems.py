"""The published recipe of random friction problems.

Deterministic by seed. One problem has

* 1 to 30 coordinates with frequencies spaced by 0.5 to 1.5, dense M and K, a random joint;
* a gyroscopic matrix, in modal terms up to a fifth of the mean frequency;
* modal damping, each mode's ratio drawn from 0.2 % to 5 % (log-uniform), so C >= 0;
* one to five harmonics of a fundamental from 0.3 to 1.5 of the lowest frequency (from 0.3 to 3 for
  one coordinate), half the time a mean load too;
* Q_m from 0.02 to 1.1 of the critical torque; a third of them with Q_s up to 1.5 Q_m.

The critical torque is computed here, from the locked steady reaction, and shares no code with
beltsim.
"""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem

SHARES = (0.02, 1.1)


def random_problem(
    seed: int,
    n: int | None = None,
    *,
    share: float | None = None,
    static: bool | None = None,
    harmonics: int | None = None,
) -> FrictionProblem:
    """A random problem; `share` = Q_m/Q_cr and the other choices are drawn when not given."""
    draw = np.random.default_rng([seed, 20080101])
    n = int(draw.integers(1, 31)) if n is None else n
    harmonics = int(draw.integers(1, 6)) if harmonics is None else harmonics
    M, C, G, K, lowest = _matrices(draw, n)
    Omega = lowest * draw.uniform(0.3, 3.0 if n == 1 else 1.5)
    forcing = _forcing(draw, n, harmonics, Omega)
    joint = int(draw.integers(n))
    drawn_share = draw.uniform(*SHARES)
    factor = 1.0 + draw.uniform(0.01, 0.5)
    has_static = draw.random() < 1.0 / 3.0 if static is None else static
    frictionless = FrictionProblem(M, C, G, K, joint, forcing, Coulomb(0.0))
    Q_m = critical_torque(frictionless) * (drawn_share if share is None else share)
    return frictionless.with_friction(Coulomb(Q_m, Q_m * factor if has_static else None))


def random_state(seed: int, problem: FrictionProblem) -> np.ndarray:
    """An initial state (2n,) of about the size of the forced motion, the joint moving."""
    draw = np.random.default_rng([seed, 7])
    size = np.abs(np.linalg.solve(problem.K, problem.forcing.cos.T)).max() + 0.1
    q = size * draw.standard_normal(problem.n)
    q_dot = size * problem.forcing.Omega * draw.standard_normal(problem.n)
    return np.concatenate([q, q_dot])


def problems(max_n: int = 30) -> st.SearchStrategy[FrictionProblem]:
    """Hypothesis strategy over the recipe."""
    return st.builds(random_problem, seed=st.integers(0, 2**32 - 1), n=st.integers(1, max_n))


def critical_torque(problem: FrictionProblem) -> float:
    """Half the peak-to-peak of the steady reaction of the joint held at zero."""
    joint, forcing = problem.joint, problem.forcing
    keep = np.delete(np.arange(problem.n), joint)
    angle = np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)
    reaction = np.zeros_like(angle)
    for k in range(1, len(forcing.cos)):
        w = k * forcing.Omega
        f = forcing.cos[k] - 1j * forcing.sin[k]
        D = problem.K + 1j * w * (problem.C + problem.G) - w**2 * problem.M
        held = f[joint]
        if len(keep):
            held = held - D[joint, keep] @ np.linalg.solve(D[np.ix_(keep, keep)], f[keep])
        reaction += np.real(held * np.exp(1j * k * angle))
    return 0.5 * float(np.ptp(reaction))


def _matrices(draw: np.random.Generator, n: int):
    """M, C, G, K with the wanted spectrum, symmetric and skew to the last bit."""
    frequencies = draw.uniform(0.5, 1.5) + np.cumsum(draw.uniform(0.5, 1.5, n)) - 0.5
    ratios = np.exp(draw.uniform(np.log(0.002), np.log(0.05), n))
    root = np.eye(n) + 0.3 * draw.standard_normal((n, n)) / np.sqrt(n)
    M = root @ root.T
    turn, _ = np.linalg.qr(draw.standard_normal((n, n)))
    back = np.linalg.cholesky(M) @ turn  # M times the mode shapes
    K = back * frequencies**2 @ back.T
    C = back * (2.0 * ratios * frequencies) @ back.T
    skew = np.zeros((n, n))
    if n > 1:
        raw = draw.standard_normal((n, n))
        raw = raw - raw.T
        size = draw.uniform(0.0, 0.2) * frequencies.mean() / np.linalg.norm(raw, 2)
        skew = back @ raw @ back.T * size
    symmetric = [0.5 * (A + A.T) for A in (M, C, K)]
    return symmetric[0], symmetric[1], 0.5 * (skew - skew.T), symmetric[2], frequencies[0]


def _forcing(draw: np.random.Generator, n: int, harmonics: int, Omega: float) -> HarmonicForcing:
    """One to five harmonics, the higher ones weaker."""
    fall = 1.0 / np.arange(1, harmonics + 1)
    cos, sin = np.zeros((2, harmonics + 1, n))
    cos[1:] = fall[:, None] * draw.standard_normal((harmonics, n))
    sin[1:] = fall[:, None] * draw.standard_normal((harmonics, n))
    if draw.random() < 0.5:
        cos[0] = draw.standard_normal(n)
    return HarmonicForcing(Omega, cos, sin)
