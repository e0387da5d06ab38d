"""The steady state of the paper's drive by collocation of its boundary-value problem.

Table 1 is typed in here. Each span obeys T w_xx = eps2 w_xxxx with the pulleys' curvatures at its
ends; the curvature w_xx is collocated first, the deflection from it. Outer unknowns are the
tension and the arm's angle, from the sum of the spans' stretches and the balance of the arm.

No import from beltsim.
"""

import numpy as np
from scipy.optimize import root

DEGREE = 96
P0, EA, RHO = 300.0, 120_000.0, 0.1029
LENGTH = np.array([0.1548, 0.3449, 0.5518])
RADIUS = np.array([0.0889, 0.0452, 0.0270])
SIDE = np.array([1.0, -1.0, 1.0])  # the back of the belt runs on pulley 2
R_T, K_R = 0.0970, 28.25
BETA_1, BETA_2 = np.radians([135.79, 178.74])
ALPHA = 3.0


def solve(epsilon: float, Omega: float) -> tuple[float, float, float]:
    """Tension of the belt, arm angle, and deflection of span 1 at the arm, dimensionless."""
    mean = LENGTH.mean()
    s = RADIUS[0] * Omega / (ALPHA * mean)
    gamma, k_s = EA / P0, K_R / (P0 * R_T)
    preload = np.sin(BETA_1) - np.sin(BETA_2)
    stretch_per_angle = R_T * (np.sin(BETA_2) - np.sin(BETA_1))
    x, D, weights = _chebyshev(DEGREE)

    def residual(unknown: np.ndarray) -> list[float]:
        p, theta = unknown
        T = p - s**2
        stretch, shears = 0.0, []
        for i in range(3):
            shape = _span(i, T, epsilon * mean / LENGTH[i], theta, D)
            slope = D @ shape
            stretch += LENGTH[i] * 0.5 * weights @ slope**2
            curvature = D @ slope
            eps2 = (epsilon * mean / LENGTH[i]) ** 2
            shears.append(T * slope - eps2 * (D @ curvature))
        along = LENGTH.sum() * (p - 1.0) / gamma - stretch_per_angle * theta - stretch
        # the middle of the span: the shear is constant, and differentiates best there
        middle = len(x) // 2
        arm = (
            k_s * theta
            + preload
            - np.sin(BETA_1) * T
            + np.cos(BETA_1) * shears[0][middle]
            + np.sin(BETA_2) * T
            - np.cos(BETA_2) * shears[1][middle]
        )
        return [gamma / 3.0 * along, arm]

    found = root(residual, [1.0 + s**2, 0.0], tol=1e-13)
    p, theta = found.x
    if max(map(abs, residual(found.x))) > 1e-8:
        raise RuntimeError(f"collocation at epsilon = {epsilon}, Omega = {Omega}: {found.message}")
    return float(p), float(theta), float(R_T / LENGTH[0] * np.cos(BETA_1) * theta)


def _span(i: int, T: float, eps: float, theta: float, D: np.ndarray) -> np.ndarray:
    """Deflection of span i at the collocation points, x from 0 to 1."""
    bent = [SIDE[j] * LENGTH[i] / RADIUS[j] for j in (i, (i + 1) % 3)]
    ends = [0.0, 0.0]
    if i == 0:
        ends[1] = R_T / LENGTH[0] * np.cos(BETA_1) * theta
    if i == 1:
        ends[0] = R_T / LENGTH[1] * np.cos(BETA_2) * theta
    second = D @ D
    curvature = _bordered(T * np.eye(len(D)) - eps**2 * second, np.zeros(len(D)), bent)
    return _bordered(second, curvature, ends)


def _bordered(operator: np.ndarray, right: np.ndarray, ends: list[float]) -> np.ndarray:
    operator, right = operator.copy(), right.copy()
    for row, value in zip((0, -1), ends, strict=True):
        operator[row] = 0.0
        operator[row, row] = 1.0
        right[row] = value
    return np.linalg.solve(operator, right)


def _chebyshev(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points on [0, 1], differentiation matrix and Clenshaw-Curtis weights."""
    theta = np.pi * np.arange(n + 1) / n
    x = -np.cos(theta)
    c = np.ones(n + 1)
    c[[0, -1]] = 2.0
    c *= (-1.0) ** np.arange(n + 1)
    gap = x[:, None] - x[None, :] + np.eye(n + 1)
    D = np.outer(c, 1.0 / c) / gap
    D -= np.diag(D.sum(axis=1))
    k = np.arange(0, n + 1, 2)
    moments = np.zeros(n + 1)
    moments[k] = 2.0 / (1.0 - k**2)
    basis = np.cos(np.outer(theta, np.arange(n + 1)))  # T_k(-x): even k are what counts
    weights = np.linalg.solve(basis.T, moments)
    return 0.5 * (x + 1.0), 2.0 * D, 0.5 * weights
