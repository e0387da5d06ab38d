# Kernels see arrays only; numba derives their types from the call.
# ruff: noqa: ANN001, ANN202
# mypy: disallow_untyped_defs=False, disallow_incomplete_defs=False, check_untyped_defs=False
r"""Compiled kernels: the linear part seen from the joint, and all coordinates under its torque.

With :math:`D(w) = K + i w (C + G) - w^2 M`, one elimination per harmonic gives the response to a
unit torque on the joint and to the forcing. Real and imaginary parts are kept apart, in rows as
long as whole vector registers, so that the inner loops compile to vector instructions; slices tell
the compiler that no index wraps around.

Depends on: _kernels.
"""

from __future__ import annotations

import numpy as np

from beltsim.harmonic_balance._kernels import compiled


@compiled
def excited(cos, sin):
    """Harmonics (of 0, 1, ...) with a load, ascending."""
    found, count = np.empty(len(cos), np.int64), 0
    for k in range(len(cos)):
        for i in range(cos.shape[1]):
            if cos[k, i] != 0.0 or sin[k, i] != 0.0:
                found[count] = k
                count += 1
                break
    return found[:count].copy()


@compiled
def condensed(M, C, G, K, joint, Omega, orders, cos, sin, limit):
    r"""Solutions of :math:`D(r\Omega) y = e_t` and `= load`, and what the joint sees of them.

    Parameters
    ----------
    M, C, G, K : (n, n)
    joint : int
    Omega : float
    orders : (nS,) int
    cos, sin : (H + 1, n) the load.
    limit : float
        Answers above load over stiffness by more than this, in coordinates of unit mass, are not
        sound.

    Returns
    -------
    unit, free : (nS, n) complex
    mobility, velocity, reaction : (nS,) complex, as `seen` finds them.
    faulty : int
        First harmonic (its place in `orders`) whose answers are not sound, or -1.
    """
    n, count = len(M), len(orders)
    unit, free = np.zeros((count, n), np.complex128), np.zeros((count, n), np.complex128)
    width = (n + 5) // 4 * 4
    re, im, highest = np.zeros((n, width)), np.zeros((n, width)), np.empty(n)
    B, root, faulty = C + G, np.sqrt(np.diag(M)), -1
    for r in range(count):
        w = orders[r] * Omega
        square, load = w * w, 0.0
        highest[:] = 0.0
        for i in range(n):
            a, b, m, d, k = re[i], im[i], M[i], B[i], K[i]
            scale = 1.0 / root[i]
            for j in range(n):
                a[j] = k[j] - square * m[j]
                b[j] = w * d[j]
                highest[j] = max(highest[j], (abs(a[j]) + abs(b[j])) * scale)
            a[n], b[n], a[n + 1], b[n + 1] = 0.0, 0.0, 0.0, 0.0
            if orders[r] < len(cos):
                a[n + 1], b[n + 1] = cos[orders[r], i], -sin[orders[r], i]
                load = max(load, (abs(a[n + 1]) + abs(b[n + 1])) * scale)
        re[joint, n] = 1.0
        regular = eliminated(re, im, n)
        stiffness = np.max(highest / root)
        sound_unit = substituted(re, im, n, root, limit / root[joint] / stiffness, unit[r])
        sound_free = substituted(re, im, n + 1, root, limit * load / stiffness, free[r])
        if not (regular and sound_unit and (sound_free or load == 0.0)):
            faulty = r
            break
    mobility, velocity, reaction = seen(unit, free, joint, Omega, orders)
    return unit, free, mobility, velocity, reaction, faulty


@compiled
def eliminated(re, im, n):
    """Whether the n columns before the right sides could be brought to upper triangular form.

    Pivots are replaced by their inverses. Whole registers are worked on, so that entries left of
    the diagonal hold nothing of use afterwards.
    """
    for k in range(n):
        p, largest = k, 0.0
        for i in range(k, n):
            here = abs(re[i, k]) + abs(im[i, k])
            if here > largest:
                p, largest = i, here
        if not largest > 0.0:
            return False
        if p != k:
            a, b, x, y = re[k], im[k], re[p], im[p]
            for j in range(len(a)):
                a[j], x[j] = x[j], a[j]
                b[j], y[j] = y[j], b[j]
        square = re[k, k] * re[k, k] + im[k, k] * im[k, k]
        e, f = re[k, k] / square, -im[k, k] / square
        start = (k + 1) // 4 * 4
        a, b = re[k, start:], im[k, start:]
        for i in range(k + 1, n):
            c = re[i, k] * e - im[i, k] * f
            d = re[i, k] * f + im[i, k] * e
            x, y = re[i, start:], im[i, start:]
            for j in range(len(x)):
                x[j] -= c * a[j] - d * b[j]
                y[j] -= c * b[j] + d * a[j]
        re[k, k], im[k, k] = e, f
    return True


@compiled
def substituted(re, im, column, root, most, found):
    """Solution `found` (n,) for a right side; whether none is above `most` at unit mass."""
    sound = True
    for k in range(len(found) - 1, -1, -1):
        c = re[k, column] * re[k, k] - im[k, column] * im[k, k]
        d = re[k, column] * im[k, k] + im[k, column] * re[k, k]
        found[k] = complex(c, d)
        sound = sound and (abs(c) + abs(d)) * root[k] <= most
        for i in range(k):
            re[i, column] -= re[i, k] * c - im[i, k] * d
            im[i, column] -= re[i, k] * d + im[i, k] * c
    return sound


@compiled
def seen(unit, free, joint, Omega, orders):
    """Mobility, velocity without friction, and torque that holds the joint, each (nS,)."""
    count = len(orders)
    mobility, velocity = np.empty(count, np.complex128), np.empty(count, np.complex128)
    reaction = np.zeros(count, np.complex128)
    for r in range(count):
        s = complex(0.0, orders[r] * Omega)
        mobility[r], velocity[r] = s * unit[r, joint], s * free[r, joint]
        if free[r, joint] != 0.0:
            node = unit[r, joint] == 0.0
            reaction[r] = complex(np.inf, 0.0) if node else free[r, joint] / unit[r, joint]
    return mobility, velocity, reaction


@compiled
def coordinates(M, C, G, K, joint, Omega, orders, cos, sin, unit, free, torque):
    """All coordinates under the torque harmonics (nS,), and how well they balance the loads.

    Returns
    -------
    q : (nS, n) complex
    squares : (n,) mean squares over the period, mean position left out.
    power : float
        Mean power that the torque takes.
    residual : float
        Largest unbalanced load of any harmonic over the largest part, from M, C, G, K alone.
    """
    count, n = unit.shape
    q, rows = np.empty((count, n), np.complex128), np.empty((2 * count, n))
    squares, power = np.zeros(n), 0.0
    for r in range(count):
        for j in range(n):
            q[r, j] = free[r, j] - unit[r, j] * torque[r]
            rows[2 * r, j], rows[2 * r + 1, j] = q[r, j].real, q[r, j].imag
            squares[j] += 0.5 * (q[r, j].real * q[r, j].real + q[r, j].imag * q[r, j].imag)
        moved = complex(0.0, orders[r] * Omega) * q[r, joint]
        power += 0.5 * (torque[r].real * moved.real + torque[r].imag * moved.imag)
    spring, inertia, damping = rows @ K, rows @ M, rows @ (C - G)  # q^T (C - G) = ((C + G) q)^T
    size, worst = 0.0, 0.0
    for r in range(count):
        w = orders[r] * Omega
        for j in range(n):
            k = complex(spring[2 * r, j], spring[2 * r + 1, j])
            m = w * w * complex(inertia[2 * r, j], inertia[2 * r + 1, j])
            d = w * complex(-damping[2 * r + 1, j], damping[2 * r, j])
            f = 0j
            if orders[r] < len(cos):
                f = complex(cos[orders[r], j], -sin[orders[r], j])
            left = k - m + d - f
            if j == joint:
                left += torque[r]
            size = max(size, _size(k), _size(m), _size(d), _size(f))
            gap = _size(left)
            if not gap <= worst:
                worst = gap if gap < np.inf else np.inf  # nan counts as unbalanced too
    return q, squares, power, worst / size if worst > 0.0 else 0.0


@compiled
def _size(z):
    return abs(z.real) + abs(z.imag)
