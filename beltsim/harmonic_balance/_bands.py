# Kernels see arrays only; numba derives their types from the call.
# ruff: noqa: ANN001, ANN202
# mypy: disallow_untyped_defs=False, disallow_incomplete_defs=False, check_untyped_defs=False
r"""Compiled kernels: the saturated torque of a truncated velocity, in closed form.

.. math:: h(\tau) = \mathrm{clip}(v/\sigma, -1, 1), \qquad
          h_r = \frac{m}{\pi}\int h\,e_r\,d\tau = \frac{m}{\pi}\Big(
          \sum_{\text{outside}} \pm\!\int e_r\,d\tau
          + \frac{1}{\sigma}\sum_s x_s \sum_{\text{inside}} \int e_r e_s\,d\tau\Big)

with :math:`e_r` the cosines and sines of :math:`v = \sum_s x_s e_s`. The edges of the zones, where
:math:`|v| = \sigma`, are roots of the series and the integrals are those of single cosines, since
products are sums of them. Nothing is sampled, so nothing aliases. The law is continuous, so edges
add nothing to the derivative: it is the integral over the band, :math:`\partial h_r/\partial x_s =
(m/\pi\sigma)\sum_{\text{inside}}\int e_r e_s\,d\tau`.

No edge is missed: a cell is left only when bounds of the series' derivatives show that v does not
reach a threshold there or is monotone there; otherwise it is halved. Two edges can escape only from
a cell of `LEAST_CELL`, where v passes a threshold by less than rounding.

Units and pairs are those of `_kernels`; m = `images`.

Depends on: _kernels (for `compiled` alone).
"""

from __future__ import annotations

import numpy as np

from beltsim.harmonic_balance._kernels import compiled

#: Cells per harmonic and period in which the search begins.
FIRST_CELLS = 6
#: Width, over the shortest half wave, below which a cell is not halved any more.
LEAST_CELL = 1e-7


@compiled
def derivatives(angle, orders, x):
    """v, v' and v'' at one angle, for equally spaced orders."""
    z = np.exp(1j * (orders[0] * angle))
    turn = np.exp(1j * (orders[min(1, len(orders) - 1)] - orders[0]) * angle)
    v, slope, bend = 0.0, 0.0, 0.0
    for k in range(len(orders)):
        r = orders[k]
        value = x[2 * k] * z.real + x[2 * k + 1] * z.imag
        v += value
        slope += r * (x[2 * k + 1] * z.real - x[2 * k] * z.imag)
        bend -= r * r * value
        z = z * turn
    return v, slope, bend


@compiled
def zone_of(v, sigma):
    """1 or -1 outside the band, 0 inside."""
    if v >= sigma:
        return 1
    return -1 if v <= -sigma else 0


@compiled
def edge(low, high, level, rising, orders, x):
    """The angle between `low` and `high` where v = level, for a monotone v."""
    angle = 0.5 * (low + high)
    for _ in range(80):
        v, slope, _ = derivatives(angle, orders, x)
        if (v < level) == rising:
            low = angle
        else:
            high = angle
        following = angle - (v - level) / slope if slope != 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - angle) <= 1e-16 * high:
            return following
        angle = following
    return angle


@compiled
def zones(x, orders, images, sigma, bounds, levels):
    """Zones of one period, or half of it; their number.

    Zone j goes from `bounds[j]` to `bounds[j + 1]`; `levels[j]` is 1 or -1 outside the band, 0
    inside.
    """
    highest, period = orders[-1], 2.0 * np.pi / images
    cells = FIRST_CELLS * (highest + 1) // images
    most_bend, most_twist = 0.0, 0.0  # bounds of |v''| and |v'''|
    for k in range(len(orders)):
        size = np.hypot(x[2 * k], x[2 * k + 1]) * orders[k] ** 2
        most_bend += size
        most_twist += size * orders[k]
    least = LEAST_CELL * np.pi / highest
    ends, values = np.empty(64), np.empty(64)  # right ends of the cells that wait, nearest last
    start, now, count = 0.0, zone_of(derivatives(0.0, orders, x)[0], sigma), 0
    bounds[0], levels[0] = 0.0, now
    for g in range(cells):
        ends[0] = period * ((g + 1) / cells)
        values[0] = derivatives(ends[0], orders, x)[0]
        waiting = 1
        while waiting > 0:
            end, v_end = ends[waiting - 1], values[waiting - 1]
            width, middle = end - start, 0.5 * (start + end)
            v, slope, bend = derivatives(middle, orders, x)
            bend = min(most_bend, abs(bend) + 0.5 * width * most_twist)
            reach = 0.5 * width * (abs(slope) + 0.25 * width * bend)
            clear = reach < abs(abs(v) - sigma)
            if not clear and abs(slope) <= 0.5 * width * bend and width > least and waiting < 64:
                ends[waiting], values[waiting] = middle, v
                waiting += 1
                continue
            goal = zone_of(v if clear else v_end, sigma)
            while now != goal and count + 2 < len(bounds):
                following = now + 1 if goal > now else now - 1
                level = (now + following) * sigma  # of the threshold between both zones
                count += 1
                bounds[count] = edge(start, end, level, goal > now, orders, x)
                levels[count] = now = following
            start = end
            waiting -= 1
    bounds[count + 1] = period
    return count + 1


@compiled
def projected(x, orders, images, sigma):
    """Harmonics of h = clip(v/sigma, -1, 1), integrated exactly.

    Parameters
    ----------
    x : (m,) pairs of the velocity's harmonics.
    orders : (nS,) equally spaced, from 1 on when images = 1, m = 2 nS.
    images : int
    sigma : float

    Returns
    -------
    pairs : (m,) harmonics of h.
    slope : (m, m) their derivative by x.
    mean : float
        Mean of h; 0 when half a period tells all.
    """
    m, step, most = len(x), images, 2 * orders[-1] // images + 1
    bounds, levels = np.empty(12 * orders[-1] + 16), np.empty(12 * orders[-1] + 16)
    count = zones(x, orders, images, sigma, bounds, levels)
    pairs, slope = np.zeros(m), np.empty((m, m))
    inside = np.zeros(most, np.complex128)  # integrals of exp(i p tau) over the band, p = step j
    mean = 0.0
    for j in range(count):
        low, high, level = bounds[j], bounds[j + 1], levels[j]
        width, middle = high - low, 0.5 * (low + high)
        first = step if level == 0.0 else orders[0]
        z, half = np.exp(1j * (first * middle)), np.exp(0.5j * (first * width))
        turn, half_turn = np.exp(1j * (step * middle)), np.exp(0.5j * (step * width))
        if level == 0.0:  # midpoint forms: exact to rounding however narrow the zone
            inside[0] += width
            for i in range(1, most):
                inside[i] += z * (2.0 * half.imag / (step * i))
                z, half = z * turn, half * half_turn
        else:
            mean += level * width
            for k in range(len(orders)):
                share = level * 2.0 * half.imag / orders[k]
                pairs[2 * k] += share * z.real
                pairs[2 * k + 1] += share * z.imag
                z, half = z * turn, half * half_turn
    scale = 0.5 * images / np.pi
    for k in range(len(orders)):
        for i in range(len(orders)):
            apart, together = (orders[k] - orders[i]) // step, (orders[k] + orders[i]) // step
            less, more = inside[abs(apart)], inside[together]
            turned = less.imag if apart > 0 else -less.imag
            slope[2 * k, 2 * i] = scale * (less.real + more.real)
            slope[2 * k + 1, 2 * i + 1] = scale * (less.real - more.real)
            slope[2 * k + 1, 2 * i] = scale * (more.imag + turned)
            slope[2 * k, 2 * i + 1] = scale * (more.imag - turned)
    slope /= sigma
    pairs *= 2.0 * scale
    pairs += slope @ x
    if images == 2:
        return pairs, slope, 0.0
    for k in range(len(orders)):
        mean += (x[2 * k] * inside[k + 1].real + x[2 * k + 1] * inside[k + 1].imag) / sigma
    return pairs, slope, mean / (2.0 * np.pi)
