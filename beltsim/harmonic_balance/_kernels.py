# Kernels see arrays only; numba derives their types from the call.
# ruff: noqa: ANN001, ANN202
# mypy: disallow_untyped_defs=False, disallow_incomplete_defs=False, check_untyped_defs=False
r"""Compiled kernels: the interior-point iterations on the condensed, cell-wise friction problem.

Everything here is dimensionless: torques are divided by Q_m, velocities by the rms of the
frictionless velocity. Real vectors hold pairs per harmonic, `(Re V_r, -Im V_r)`, so that
:math:`v = \mathrm{table}\cdot x` with columns `cos, sin`. The mobility acts on a pair of torque
coefficients `(c, s)` (torque `c cos + s sin`) as `(Re A c + Im A s, Re A s - Im A c)`.

The arithmetic is strict (no fast-math), so results do not depend on the compiler's mood. Compiled
code is kept on disk where a folder for it can be written, and in memory otherwise.

Depends on: nothing but numba.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from beltsim.checks import FloatArray

#: Least share of the mean complementarity product that the smallest may have after a step.
CENTRALITY = 1e-4
#: Share of the way to the border that a step may go.
TO_BORDER = 0.995
#: Columns that are factorised at a time.
BLOCK = 64


def compiled(function: Callable[..., Any]) -> Any:
    """`function` compiled by numba, cached on disk if some folder can be written."""
    try:
        return njit(cache=True, fastmath=False, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # numba found no folder for its cache
        return njit(cache=False, fastmath=False, nogil=True, error_model="numpy")(function)


@compiled
def factorise(a, pivots):
    """LU factors of `a` (m, m) in place, with row exchanges `pivots` (m,).

    Columns are worked on in blocks; what a block does to the columns right of it is one product.
    """
    m = a.shape[0]
    for first in range(0, m, BLOCK):
        last = min(first + BLOCK, m)
        for k in range(first, last):
            p = k
            for i in range(k + 1, m):
                if abs(a[i, k]) > abs(a[p, k]):
                    p = i
            pivots[k] = p
            if p != k:
                for j in range(m):
                    a[k, j], a[p, j] = a[p, j], a[k, j]
            scale, above = 1.0 / a[k, k], a[k, k + 1 : last]
            for i in range(k + 1, m):
                factor, row = a[i, k] * scale, a[i, k + 1 : last]  # slices make vector instructions
                a[i, k] = factor
                for j in range(len(row)):
                    row[j] -= factor * above[j]
        if last == m:
            break
        for k in range(first, last):
            above = a[k, last:]
            for i in range(k + 1, last):
                factor, row = a[i, k], a[i, last:]
                for j in range(len(row)):
                    row[j] -= factor * above[j]
        change = a[last:, first:last].copy() @ a[first:last, last:].copy()
        for i in range(last, m):
            row, by = a[i, last:], change[i - last]
            for j in range(len(row)):
                row[j] -= by[j]


@compiled
def substitute(a, pivots, b):
    """Solution of a system factorised by `factorise`, in place of `b` (m,)."""
    m = len(b)
    for k in range(m):
        p = pivots[k]
        if p != k:
            b[k], b[p] = b[p], b[k]
    for i in range(1, m):
        total = b[i]
        for j in range(i):
            total -= a[i, j] * b[j]
        b[i] = total
    for i in range(m - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, m):
            total -= a[i, j] * b[j]
        b[i] = total / a[i, i]


@compiled
def apply_mobility(mobility, pairs):
    """Velocity pairs that the torque pairs `pairs` (2 nS,) cause, in place."""
    for k in range(len(mobility)):
        c, s = pairs[2 * k], pairs[2 * k + 1]
        a, b = mobility[k].real, mobility[k].imag
        pairs[2 * k] = a * c + b * s
        pairs[2 * k + 1] = a * s - b * c


@compiled
def border(h_step, up_step, down_step, above, below, up, down):
    """Longest step, at most 1, that keeps both gaps and both multipliers from turning negative."""
    alpha = 1.0
    for j in range(len(above)):
        if h_step[j] * alpha > above[j]:
            alpha = above[j] / h_step[j]
        if -h_step[j] * alpha > below[j]:
            alpha = -below[j] / h_step[j]
        if -up_step[j] * alpha > up[j]:
            alpha = -up[j] / up_step[j]
        if -down_step[j] * alpha > down[j]:
            alpha = -down[j] / down_step[j]
    return alpha


@compiled
def centred(alpha, h_step, up_step, down_step, above, below, up, down, weight):
    """`alpha`, shortened until no product is far below their weighted mean."""
    total = np.sum(weight)
    for _ in range(60):
        mean, least = 0.0, np.inf
        for j in range(len(above)):
            first = (up[j] + alpha * up_step[j]) * (above[j] - alpha * h_step[j])
            second = (down[j] + alpha * down_step[j]) * (below[j] + alpha * h_step[j])
            mean += weight[j] * (first + second)
            least = min(least, first, second)
        if least >= CENTRALITY * mean / (2.0 * total):
            break
        alpha *= 0.8
    return alpha


@compiled
def interior_point(table, weight, mobility, free, compliance, tolerance, most):
    r"""Torque in cells with :math:`|h| \le 1` and :math:`h = \mathrm{sgn}\,v` where v moves.

    Solves the monotone complementarity problem

    .. math:: v = T(x_0 - A T^T w h), \quad v = p - n,\ p(1 - h) = 0,\ n(1 + h) = 0,\ p, n \ge 0

    by a feasible primal-dual path with second-order corrections. With a `compliance` s, v - s h
    takes the place of v, which is the saturated law h = clip(v/s, -1, 1). T holds cell averages (or
    point values) of the harmonics, w the weight of each cell. A has a non-negative real part, so
    the path exists for any data and every step shortens it.

    Parameters
    ----------
    table : (N, 2 nS), weight : (N,), mobility : (nS,) complex, free : (2 nS,)
    compliance : float
    tolerance : float
        Largest mean product, and largest error of the velocities, at which to stop.
    most : int
        Most iterations.

    Returns
    -------
    h, v : (N,) torque and velocity in the cells.
    residuals : (iterations + 1,) residual before each iteration, the best one last.
    """
    N, m = table.shape
    total = np.sum(weight)
    h, above, below = np.zeros(N), np.ones(N), np.ones(N)
    up, down = np.empty(N), np.empty(N)
    v = table @ free
    size = np.max(np.abs(v))
    for j in range(N):  # feasible from the start: up - down = v at h = 0
        root = np.sqrt(0.25 * v[j] * v[j] + size * size)
        large = 0.5 * abs(v[j]) + root
        up[j] = large if v[j] > 0.0 else size * size / large
        down[j] = size * size / large if v[j] > 0.0 else large
    matrix, pivots = np.empty((m, m)), np.empty(m, np.int64)
    flex, gap, scaled = np.empty(N), np.empty(N), np.empty((N, m))
    h_step, up_step, down_step = np.empty(N), np.empty(N), np.empty(N)
    residuals, best = np.empty(most + 1), np.inf
    h_best, v_best, count = h.copy(), v.copy(), 0
    for iteration in range(most + 1):
        moved = table.T @ (weight * h)
        apply_mobility(mobility, moved)
        v = table @ (free - moved) - compliance * h
        mean = 0.0
        worst = 0.0
        for j in range(N):
            mean += weight[j] * (up[j] * above[j] + down[j] * below[j])
            worst = max(worst, abs(up[j] - down[j] - v[j]))
        mean /= 2.0 * total
        residuals[iteration] = max(mean, worst)
        count = iteration
        if residuals[iteration] < best:
            best = residuals[iteration]
            h_best[:] = h
            v_best[:] = v
        # rounding ends the progress: past the best point products only lose their meaning
        if best < tolerance or residuals[iteration] > 1e3 * best or iteration == most:
            break
        for j in range(N):
            flex[j] = 1.0 / (up[j] / above[j] + down[j] / below[j] + compliance)
            for k in range(m):
                scaled[j, k] = table[j, k] * (flex[j] * weight[j])
        product = table.T @ scaled
        for k in range(m // 2):
            a, b = mobility[k].real, mobility[k].imag
            for i in range(m):
                c, s = product[2 * k, i], product[2 * k + 1, i]
                matrix[2 * k, i] = a * c + b * s
                matrix[2 * k + 1, i] = a * s - b * c
        for k in range(m):
            matrix[k, k] += 1.0
        factorise(matrix, pivots)
        target, alpha = 0.0, 1.0
        for stage in range(3):  # predictor, corrector, and plain centring if that is stopped early
            for j in range(N):
                first = target - above[j] * up[j]
                second = target - below[j] * down[j]
                if stage == 1:
                    first += h_step[j] * up_step[j]
                    second -= h_step[j] * down_step[j]
                up_step[j] = first / above[j]
                down_step[j] = second / below[j]
                gap[j] = v[j] - up[j] + down[j] - up_step[j] + down_step[j]
            x = scaled.T @ gap
            apply_mobility(mobility, x)
            substitute(matrix, pivots, x)
            change = table @ x
            for j in range(N):
                h_step[j] = flex[j] * (gap[j] - change[j])
                up_step[j] += up[j] * h_step[j] / above[j]
                down_step[j] -= down[j] * h_step[j] / below[j]
            alpha = border(h_step, up_step, down_step, above, below, up, down)
            if stage == 0:
                reached = 0.0
                for j in range(N):
                    first = (up[j] + alpha * up_step[j]) * (above[j] - alpha * h_step[j])
                    second = (down[j] + alpha * down_step[j]) * (below[j] + alpha * h_step[j])
                    reached += weight[j] * (first + second)
                target = mean * (reached / (2.0 * total * mean)) ** 3
                continue
            alpha = min(1.0, TO_BORDER * alpha)
            alpha = centred(alpha, h_step, up_step, down_step, above, below, up, down, weight)
            if alpha >= 0.1:
                break
            target = 0.3 * mean
        for j in range(N):
            h[j] += alpha * h_step[j]
            above[j] -= alpha * h_step[j]
            below[j] += alpha * h_step[j]
            up[j] += alpha * up_step[j]
            down[j] += alpha * down_step[j]
    return h_best, v_best, residuals[: count + 1].copy()


@compiled
def least_bound(table, weight, wanted, tolerance, most):
    r"""Least sup-norm of a torque in cells whose coefficients `table' (weight h)` equal `wanted`.

    A linear program, minimise Q subject to :math:`|h_j| \le Q` and
    :math:`T^T w h = \mathrm{wanted}`, by a primal-dual interior-point method. The multipliers
    `x` of the equality make a velocity `T x` of unit mean size that has the sign of h.

    Returns
    -------
    low, high : float
        Bounds of the least norm: from the multipliers and from the torque.
    x : (m,) the multipliers.
    residuals : (iterations + 1,)
    """
    N, m = table.shape
    total = np.sum(weight)
    scale = np.max(np.abs(wanted))
    gram = table.T @ (table * weight.reshape(-1, 1))
    pivots = np.empty(m, np.int64)
    start = wanted.copy()
    factorise(gram, pivots)
    substitute(gram, pivots, start)
    h = table @ start  # least squares: feasible from the start
    Q = 1.5 * np.max(np.abs(h))
    above, below = Q - h, Q + h
    up, down = np.full(N, 0.5 / total), np.full(N, 0.5 / total)
    x = np.zeros(m)
    matrix, pivots = np.empty((m + 1, m + 1)), np.empty(m + 1, np.int64)
    flex, skew, gap, right = np.empty(N), np.empty(N), np.empty(N), np.empty(m + 1)
    h_step, up_step, down_step = np.empty(N), np.empty(N), np.empty(N)
    above_step, below_step = np.empty(N), np.empty(N)
    residuals, count = np.empty(most + 1), 0
    low, high, best, x_best = 0.0, Q, np.inf, x.copy()
    for iteration in range(most + 1):
        v = table @ x
        held = table.T @ (weight * h)
        mean = 0.0
        for j in range(N):
            mean += weight[j] * (up[j] * above[j] + down[j] * below[j])
        size = np.sum(weight * np.abs(v))
        bound = wanted @ x / size if size > 0.0 else 0.0
        error = np.max(np.abs(held - wanted)) / scale
        residuals[iteration] = max((Q - bound) / Q, error)
        count = iteration
        if residuals[iteration] < best:
            best, low, high = residuals[iteration], bound, np.max(np.abs(h))
            x_best[:] = x
        if best < tolerance or residuals[iteration] > 1e3 * best or iteration == most:
            break
        for j in range(N):
            first, second = up[j] / above[j], down[j] / below[j]
            flex[j] = 1.0 / (first + second)
            skew[j] = first - second
        scaled = table * (flex * weight).reshape(-1, 1)
        matrix[:m, :m] = table.T @ scaled
        matrix[:m, m] = scaled.T @ skew
        matrix[m, :m] = matrix[:m, m]
        matrix[m, m] = 0.0
        for j in range(N):
            first, second = up[j] / above[j], down[j] / below[j]
            matrix[m, m] -= weight[j] * 4.0 * first * second * flex[j]
        factorise(matrix, pivots)
        target, alpha = 0.0, 1.0
        for stage in range(2):
            rest = 1.0
            for j in range(N):
                first = target - above[j] * up[j]
                second = target - below[j] * down[j]
                if stage == 1:
                    first -= above_step[j] * up_step[j]
                    second -= below_step[j] * down_step[j]
                up_step[j] = first / above[j]
                down_step[j] = second / below[j]
                gap[j] = v[j] - up[j] + down[j] - up_step[j] + down_step[j]
                rest -= weight[j] * (up[j] + down[j] + up_step[j] + down_step[j])
                rest -= weight[j] * skew[j] * flex[j] * gap[j]
            right[:m] = wanted - held - scaled.T @ gap
            right[m] = rest
            substitute(matrix, pivots, right)
            Q_step = right[m]
            change = table @ right[:m]
            alpha = 1.0
            for j in range(N):
                h_step[j] = flex[j] * (gap[j] + skew[j] * Q_step + change[j])
                above_step[j], below_step[j] = Q_step - h_step[j], Q_step + h_step[j]
                up_step[j] -= up[j] * above_step[j] / above[j]
                down_step[j] -= down[j] * below_step[j] / below[j]
                if -above_step[j] * alpha > above[j]:
                    alpha = -above[j] / above_step[j]
                if -below_step[j] * alpha > below[j]:
                    alpha = -below[j] / below_step[j]
                if -up_step[j] * alpha > up[j]:
                    alpha = -up[j] / up_step[j]
                if -down_step[j] * alpha > down[j]:
                    alpha = -down[j] / down_step[j]
            if stage == 0:
                reached = 0.0
                for j in range(N):
                    first = (up[j] + alpha * up_step[j]) * (above[j] + alpha * above_step[j])
                    second = (down[j] + alpha * down_step[j]) * (below[j] + alpha * below_step[j])
                    reached += weight[j] * (first + second)
                target = mean / (2.0 * total) * (reached / mean) ** 3
        alpha = min(1.0, 0.99 * alpha)
        h += alpha * h_step
        above += alpha * above_step
        below += alpha * below_step
        up += alpha * up_step
        down += alpha * down_step
        x += alpha * right[:m]
        Q += alpha * Q_step
    return low, high, x_best, residuals[: count + 1].copy()


@compiled
def misfit(grid, x, bounds, levels):
    """Mean of |v| and of |v| - h v at the middles of equal steps.

    `grid` (G, m) holds the harmonics there, `x` (m,) those of v; h is `levels[j]` from `bounds[j]`
    to `bounds[j + 1]`, and `bounds` end with the grid.
    """
    count = len(grid)
    v, step = grid @ x, bounds[-1] / count
    moving, missing, j = 0.0, 0.0, 0
    for g in range(count):
        while j + 1 < len(levels) and bounds[j + 1] <= (g + 0.5) * step:
            j += 1
        moving += abs(v[g])
        missing += abs(v[g]) - levels[j] * v[g]
    return moving / count, missing / count


@compiled
def relative_gap(grid, x, bounds, levels, still):
    """1 - int h v / int |v|; below `still`, that takes the place of int |v|."""
    moving, missing = misfit(grid, x, bounds, levels)
    return max(0.0, missing / max(moving, still))


def warm_up() -> FloatArray:
    """Compile or load every kernel on a problem of one harmonic; its residuals."""
    t = (np.arange(8) + 0.5) * np.pi / 8
    table = np.stack([np.cos(t), np.sin(t)], axis=1)
    weight = np.full(8, 0.25)
    interior_point(table, weight, np.ones(1, complex), np.array([2.0, 0.0]), 0.0, 1e-9, 30)
    found: FloatArray = least_bound(table, weight, np.array([1.0, 0.0]), 1e-9, 30)[3]
    return found
