# Kernels see arrays only; numba derives their types from the call.
# ruff: noqa: ANN001, ANN202
# mypy: disallow_untyped_defs=False, disallow_incomplete_defs=False, check_untyped_defs=False
r"""Compiled kernels: the switching instants of the truncated Coulomb problem, exactly.

A truncated velocity that is not zero vanishes at single instants only, so the torque jumps between
its bounds and is known from its switching instants :math:`\tau_1 < \dots < \tau_p` alone. They
solve

.. math:: v(\tau_i) = 0, \qquad v = x_0 - A\,g(\tau), \qquad
          g_r = \frac{m}{i\pi r}\sum_i \pm 2\,e^{-ir\tau_i},

a Newton iteration whose matrix, :math:`|v'(\tau_i)|\delta_{ij} + \frac{2m}{\pi} e_i^T A e_j`, is
positive definite however small the ripples of v are. Which instants there are is found by

1. `path`: the same problem for a torque constant in equal cells is a linear complementarity
   problem; its solution is followed from no friction to the friction wanted, or, where that takes
   many steps, found by the interior-point method;
2. pairs of instants born where v has the wrong sign, and taken out where they meet.

`searched` does all of it. Units and pairs are those of `_kernels`; m = `images`.

Depends on: _kernels.
"""

from __future__ import annotations

import numpy as np

from beltsim.harmonic_balance._kernels import (
    BLOCK,
    apply_mobility,
    compiled,
    factorise,
    interior_point,
    relative_gap,
    substitute,
)

#: Share of the distance between two neighbours that a step must leave.
LEFT = 0.03
#: Neighbours closer than this share of the shortest half wave have met.
MET = 1e-5
#: Share of the largest harmonic by which v may have the wrong sign between grid points.
WRONG = 1e-8
#: Cells whose torque is this close to a bound are at it: on the path, and after the interior-point
#: method.
AT_BOUND, EDGE = 1e-9, 1e-2
#: Cells beyond which a path that is not short is given up.
MANY = 400
#: Residual at which the interior-point method gives way to the search for instants, and its most
#: iterations.
INTERIOR, MOST_INTERIOR = 1e-8, 60


@compiled
def waves(angle, orders, row):
    """cos(r angle), sin(r angle) in pairs, for equally spaced orders."""
    z = np.exp(1j * (orders[0] * angle))
    turn = np.exp(1j * (orders[min(1, len(orders) - 1)] - orders[0]) * angle)
    for k in range(len(orders)):
        row[2 * k] = z.real
        row[2 * k + 1] = z.imag
        z = z * turn


@compiled
def path(table, weight, images, mobility, free, most):
    r"""Torque in equal cells, followed from no friction up to the friction in `mobility`.

    With the cell averages y of v and the level :math:`\lambda \ge 1` (the frictionless velocity
    over its real size), :math:`y = \lambda y_0 - W h` is complementary to :math:`|h| \le 1`. The
    solution is piecewise linear in the level; at each of its corners one cell changes between
    moving (h at a bound) and sticking (y = 0), which is one principal pivot of W.

    Returns
    -------
    h : (N,)
    pivots : int
        Their number; `most` when the path was not followed to its end.
    """
    N, m = table.shape
    P, work = np.empty((N, N)), np.empty(m)
    for d in range(N):  # equal cells: W depends on the distance alone
        for k in range(m):
            work[k] = table[d, k] * weight[d]
        apply_mobility(mobility, work)
        total = 0.0
        for k in range(m):
            total += table[0, k] * work[k]
        for j in range(N - d):
            P[j, j + d] = -total
        for j in range(N - d, N):
            P[j, j + d - N] = -total if images == 1 else total
    a = table @ free
    h, constant, basic = np.where(a > 0.0, 1.0, -1.0), np.empty(N), np.zeros(N, np.bool_)
    for j in range(N):
        constant[j] = np.sum(P[j] * h)
    level, last = np.inf, -1
    for pivots in range(most):
        following, which, bound = 1.0, -1, 0.0
        for j in range(N):
            if basic[j]:  # h_j = level a_j + constant_j, moving against a_j
                if a[j] == 0.0:
                    continue
                goal = 1.0 if a[j] < 0.0 else -1.0
                at = min(level, (goal - constant[j]) / a[j])
            else:  # y_j = level a_j + constant_j, of the sign of h_j
                if h[j] * a[j] <= 0.0:
                    continue
                goal = h[j]
                at = min(level, -constant[j] / a[j])
            if j == last and at > level * (1.0 - 1e-9):
                continue  # it is there already, and on its way from there
            if at > following:
                following, which, bound = at, j, goal
        if which < 0:
            for j in range(N):
                if basic[j]:
                    h[j] = min(1.0, max(-1.0, a[j] + constant[j]))
            return h, pivots
        level, j, last = following, which, which
        held = 0.0 if basic[j] else h[j]  # value of the variable that becomes basic
        given = bound if basic[j] else 0.0  # value of the one that leaves
        scale = 1.0 / P[j, j]
        for k in range(N):
            P[j, k] *= -scale
        P[j, j] = scale
        a[j] *= -scale
        constant[j] = scale * (given - constant[j]) + held
        pivot_row = P[j]
        for i in range(N):
            if i == j:
                continue
            factor, row = P[i, j], P[i]
            row[j] = 0.0
            for k in range(N):
                row[k] += factor * pivot_row[k]
            a[i] += factor * a[j]
            constant[i] += factor * (constant[j] - held)
        basic[j] = not basic[j]
        h[j] = bound
    return h, most


@compiled
def of_cells(h, weight, images, edges):
    """Instants of a torque whose cell averages are `h` (N,), one in each cell between bounds.

    `weight` (N,) is images/pi times the cells' widths.

    Returns their number and the torque's sign just before the first one; they fill `edges`.
    """
    N, begin, angle = len(h), 0, 0.0
    for j in range(N):
        if abs(h[j]) >= 1.0 - AT_BOUND:
            begin = j
            break
    for j in range(begin):
        angle += np.pi / images * weight[j]
    first = 1.0 if h[begin] > 0.0 else -1.0
    sign, count = first, 0
    for j in range(begin, begin + N):
        level = h[j] if j < N else h[j - N] * (3 - 2 * images)
        start, width = angle, np.pi / images * weight[j if j < N else j - N]
        angle = start + width
        if abs(level) < 1.0 - AT_BOUND:
            edges[count] = start + width * (0.5 * (1.0 + sign * level))
        elif sign * level < 0.0:
            edges[count] = start
        else:
            continue
        count += 1
        sign = -sign
    if sign != first * (3 - 2 * images):
        edges[count] = angle
        count += 1
    return wrapped(edges, count, first, images)


@compiled
def wrapped(edges, count, sign, images):
    """Instants turned into one period in ascending order; their number and first sign."""
    period = 2.0 * np.pi / images
    for _ in range(2 * count):
        if edges[count - 1] >= period:
            moved = edges[count - 1] - period
            for j in range(count - 1, 0, -1):
                edges[j] = edges[j - 1]
            edges[0] = moved
            sign = -sign
        elif edges[0] < 0.0:
            moved = edges[0] + period
            for j in range(count - 1):
                edges[j] = edges[j + 1]
            edges[count - 1] = moved
            sign = -sign
        else:
            break
    return count, sign


@compiled
def torque_of(edges, count, sign, orders, images, table, pairs):
    """Harmonics `pairs` (m,) of the torque; fills the rows of `table` with waves at the edges."""
    pairs[:] = 0.0
    jump = -2.0 * sign
    for i in range(count):
        waves(edges[i], orders, table[i])
        for k in range(len(orders)):
            pairs[2 * k] -= jump * table[i, 2 * k + 1]
            pairs[2 * k + 1] += jump * table[i, 2 * k]
        jump = -jump
    for k in range(len(orders)):
        pairs[2 * k] *= images / (np.pi * orders[k])
        pairs[2 * k + 1] *= images / (np.pi * orders[k])


@compiled
def with_born(edges, count, sign, images, values, limit, stiff):
    """Pairs added where v (`values` on the grid) has the wrong sign by more than `limit`.

    A pair starts as wide as lifts v to zero by itself, at the stiffness `stiff` = dv/dtau.
    """
    count, sign = wrapped(edges, count, sign, images)
    step = 2.0 * np.pi / images / len(values)
    i, s, g, before = 0, sign, 0, count
    while g < len(values):
        angle = (g + 0.5) * step
        while i < count and edges[i] <= angle:
            i += 1
            s = -s
        if s * values[g] < -limit and count + 2 <= len(edges):
            lower = edges[i - 1] if i > 0 else 0.0
            upper = edges[i] if i < count else step * len(values)
            end = peak = g
            while (
                end + 1 < len(values) and (end + 1.5) * step < upper and s * values[end + 1] < 0.0
            ):
                end += 1
                if abs(values[end]) > abs(values[peak]):
                    peak = end
            centre = (peak + 0.5) * step
            half = min(0.5 * abs(values[peak]) / stiff, 0.3 * (end - g + 1) * step)
            for j in range(count - 1, i - 1, -1):
                edges[j + 2] = edges[j]
            edges[i] = max(centre - half, lower + 0.1 * (centre - lower))
            edges[i + 1] = min(centre + half, upper - 0.1 * (upper - centre))
            count += 2
            i += 2
            g = end
        g += 1
    return count, sign, count > before


@compiled
def moved(edges, step, count, sign, period, met):
    """Edges moved by `step`; neighbours that would pass share their room, those that met go."""
    old = edges[:count].copy()
    for i in range(count):
        edges[i] += step[i]
    if count < 3:
        return count, sign
    for _ in range(3):
        for i in range(count):
            j, turn = (i + 1, 0.0) if i + 1 < count else (0, period)
            least = LEFT * (old[j] + turn - old[i])
            if edges[j] + turn - edges[i] < least:
                middle = 0.5 * (edges[j] + turn + edges[i])
                middle = min(max(middle, old[i]), old[j] + turn)
                edges[i] = middle - 0.5 * least
                edges[j] = middle + 0.5 * least - turn
    i = 0
    while i < count and count > 2:
        after = edges[i + 1] if i + 1 < count else edges[0] + period
        if after - edges[i] < met:
            if i == count - 1:  # the last meets the first of the next period
                edges[: count - 2] = edges[1 : count - 1].copy()
                sign = -sign
            else:
                edges[i : count - 2] = edges[i + 2 : count].copy()
            count -= 2
        i += 1
    return count, sign


@compiled
def polished(edges, count, sign, orders, images, mobility, free, grid, tolerance, most):
    """Newton iterations on the instants, with births and meetings, from those in `edges`.

    Returns
    -------
    count, sign : int, float
        The instants are `edges[:count]`, ascending in one period; torque before the first.
    pairs : (m,) harmonics of the torque.
    worst : float
        Largest |v(tau_i)| over the largest harmonic of v.
    steps : int
        `most` when it did not converge.
    """
    m, room, period = 2 * len(orders), len(edges), 2.0 * np.pi / images
    table, turned = np.empty((room, m)), np.empty((m, room))
    matrix, right, pivots = np.empty((room, room)), np.empty(room), np.empty(room, np.int64)
    pairs, work, x, worst = np.empty(m), np.empty(m), np.empty(m), np.inf
    product = np.empty((0, 0))
    met = MET * period / m
    stiff = 1e-300
    for k in range(len(orders)):
        stiff += 2.0 * images / np.pi * mobility[k].real
    for steps in range(most):
        torque_of(edges, count, sign, orders, images, table, pairs)
        work[:] = pairs
        apply_mobility(mobility, work)
        size = 0.0
        for k in range(m):
            x[k] = free[k] - work[k]
            size = max(size, abs(x[k]))
        worst = 0.0
        for i in range(count):
            v, slope = 0.0, 0.0
            for k in range(len(orders)):
                v += table[i, 2 * k] * x[2 * k] + table[i, 2 * k + 1] * x[2 * k + 1]
                slope += orders[k] * (
                    x[2 * k + 1] * table[i, 2 * k] - x[2 * k] * table[i, 2 * k + 1]
                )
            worst = max(worst, abs(v) / size)
            right[i] = -v
            matrix[i, i] = abs(slope)
        if worst < tolerance:
            found = with_born(edges, count, sign, images, grid @ x, WRONG * size, stiff)
            count, sign = found[0], found[1]
            if not found[2]:
                return count, sign, pairs, worst, steps
            continue
        for j in range(count):
            work[:] = table[j]
            apply_mobility(mobility, work)
            for k in range(m):
                turned[k, j] = work[k] * (2.0 * images / np.pi)
        if count > BLOCK:
            product = table[:count] @ turned[:, :count].copy()
        for i in range(count):
            row, diagonal = matrix[i, :count], matrix[i, i]
            if count > BLOCK:
                row[:] = product[i]
            else:
                row[:] = 0.0
                for k in range(m):
                    factor, wave = table[i, k], turned[k, :count]
                    for j in range(count):
                        row[j] += factor * wave[j]
            row[i] += diagonal
        factorise(matrix[:count, :count], pivots[:count])
        substitute(matrix[:count, :count], pivots[:count], right[:count])
        direction = -sign
        for i in range(count):
            right[i] *= direction
            direction = -direction
        count, sign = moved(edges, right, count, sign, period, met)
    count, sign = wrapped(edges, count, sign, images)
    return count, sign, pairs, worst, most


@compiled
def searched(
    table, weight, orders, images, mobility, velocity, Q_m, grid, judge, tolerance, most, still
):
    """Switching instants from a cold start: the path in cells, then `from_cells`.

    Parameters
    ----------
    table, weight : (N, m), (N,) equal cells.
    orders : (nS,) harmonics, m = 2 nS.
    images : int
    mobility, velocity : (nS,) complex
        Mobility of the joint, and its velocity without friction.
    Q_m : float
    grid, judge : (G, m), (J, m)
        Harmonics at the middles of equal steps, where instants that lack are looked for, and where
        the result is judged.
    tolerance : float
        Largest velocity at an instant, relative.
    most : int
        Most Newton steps.
    still : float
        Share of the motion without friction below which the joint hardly moves.

    Returns
    -------
    torque, velocity : (nS,) complex
    mean : float
        Mean torque.
    bounds, levels : (p + 1,), (p,)
        The torque over one period: its level between bounds.
    gap : float
        Gap between torque and law on `judge`.
    worst, steps : as from `polished`.
    """
    _, A, free = scaled(mobility, velocity, Q_m)
    # more cost more than an interior-point solution, the sooner the more cells there are
    most_pivots = 2 * len(table) if len(table) <= MANY else len(table) // 2
    h, pivots = path(table, weight, images, A, free, most_pivots)
    if pivots == most_pivots:
        h = interior_point(table, weight, A, free, 0.0, INTERIOR, MOST_INTERIOR)[0]
        for j in range(len(h)):
            if abs(h[j]) > 1.0 - EDGE:
                h[j] = np.sign(h[j])
    return from_cells(
        h, weight, orders, images, mobility, velocity, Q_m, grid, judge, tolerance, most, still
    )


@compiled
def from_cells(
    h, weight, orders, images, mobility, velocity, Q_m, grid, judge, tolerance, most, still
):
    """`searched`, from the torque `h` (N,) in cells of any widths."""
    size, A, free = scaled(mobility, velocity, Q_m)
    edges = np.empty(2 * len(h) + 2)
    count, sign = of_cells(h, weight, images, edges)
    count, sign, pairs, worst, steps = polished(
        edges, count, sign, orders, images, A, free, grid, tolerance, most
    )
    torque, moving = np.empty(len(orders), np.complex128), np.empty(len(orders), np.complex128)
    for k in range(len(orders)):
        torque[k] = Q_m * complex(pairs[2 * k], -pairs[2 * k + 1])
        moving[k] = velocity[k] - mobility[k] * torque[k]
        free[2 * k], free[2 * k + 1] = moving[k].real, -moving[k].imag
    bounds, levels = np.empty(count + 2), np.empty(count + 1)
    bounds[0], bounds[1 : count + 1], bounds[count + 1] = 0.0, edges[:count], 2.0 * np.pi / images
    levels[0::2], levels[1::2] = sign, -sign
    gap = relative_gap(judge, free, bounds, levels, still * size)
    if images == 2:
        bounds = np.concatenate((bounds, bounds[1:] + np.pi))
        levels = np.concatenate((levels, -levels))
        mean = 0.0
    else:
        mean = Q_m * np.sum((bounds[1:] - bounds[:-1]) * levels) / (2.0 * np.pi)
    return torque, moving, mean, bounds, Q_m * levels, gap, worst, steps


@compiled
def scaled(mobility, velocity, Q_m):
    """Rms of the velocity without friction; mobility and pairs of that velocity in its units."""
    size = np.sqrt(0.5 * np.sum(velocity.real**2 + velocity.imag**2))
    free = np.empty(2 * len(velocity))
    free[0::2], free[1::2] = velocity.real / size, -velocity.imag / size
    return size, mobility * (Q_m / size), free


@compiled
def crossings(x, orders, images, values, edges):
    """Sign changes of v between the grid's points, polished; their number and v's first sign."""
    step, count = 2.0 * np.pi / images / len(values), 0
    row = np.empty(len(x))
    before = values[-1] * (3 - 2 * images)
    first = 1.0 if before > 0.0 else -1.0
    for g in range(len(values)):
        if before * values[g] < 0.0:
            low, high = (g - 0.5) * step, (g + 0.5) * step
            angle = low + step * before / (before - values[g])
            for _ in range(60):
                waves(angle, orders, row)
                v, slope = row @ x, 0.0
                for k in range(len(orders)):
                    slope += orders[k] * (x[2 * k + 1] * row[2 * k] - x[2 * k] * row[2 * k + 1])
                if v * before > 0.0:
                    low = angle
                else:
                    high = angle
                following = angle - v / slope if slope != 0.0 else low
                if not low < following < high:
                    following = 0.5 * (low + high)
                if abs(following - angle) < 1e-15:
                    break
                angle = following
            edges[count] = angle
            count += 1
        before = values[g]
    return count, first
