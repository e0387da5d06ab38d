# Kernels see arrays only; numba derives their types from the call.
# ruff: noqa: ANN001, ANN202
# mypy: disallow_untyped_defs=False, disallow_incomplete_defs=False, check_untyped_defs=False
"""Compiled kernel: responses of the linear part to a unit torque on the joint and to the forcing.

Depends on: _kernels.
"""

from __future__ import annotations

import numpy as np

from beltsim.harmonic_balance._kernels import compiled


@compiled
def responses(M, B, K, rate, joint, load, limit):
    r"""Solutions of :math:`(K + i w B - w^2 M) y = e_t` and `= load`, one elimination per rate w.

    Real and imaginary parts are kept apart, so that the inner loops run over plain rows.

    Parameters
    ----------
    M, B, K : (n, n), B = C + G
    rate : (nS,)
    joint : int
    load : (nS, n) complex
    limit : float
        Answers above load over stiffness by more than this, in coordinates of unit mass, are not
        sound.

    Returns
    -------
    unit, free : (nS, n) complex
    faulty : int
        First rate whose answers are not sound, or -1.
    """
    n, count = len(M), len(rate)
    unit, free = np.zeros((count, n), np.complex128), np.zeros((count, n), np.complex128)
    re, im = np.empty((n, n + 2)), np.empty((n, n + 2))
    root = np.sqrt(np.diag(M))
    for r in range(count):
        w, square = rate[r], rate[r] * rate[r]
        stiffness, size = 0.0, 0.0
        for i in range(n):
            for j in range(n):
                re[i, j] = K[i, j] - square * M[i, j]
                im[i, j] = w * B[i, j]
                entry = (abs(re[i, j]) + abs(im[i, j])) / (root[i] * root[j])
                stiffness = max(stiffness, entry)
            re[i, n], im[i, n] = 0.0, 0.0
            re[i, n + 1], im[i, n + 1] = load[r, i].real, load[r, i].imag
            size = max(size, abs(load[r, i]) / root[i])
        re[joint, n] = 1.0
        for k in range(n):
            p, largest = k, abs(re[k, k]) + abs(im[k, k])
            for i in range(k + 1, n):
                if abs(re[i, k]) + abs(im[i, k]) > largest:
                    p, largest = i, abs(re[i, k]) + abs(im[i, k])
            if not largest > 0.0:
                return unit, free, r
            if p != k:
                for j in range(k, n + 2):
                    re[k, j], re[p, j] = re[p, j], re[k, j]
                    im[k, j], im[p, j] = im[p, j], im[k, j]
            square = re[k, k] * re[k, k] + im[k, k] * im[k, k]
            a, b = re[k, k] / square, -im[k, k] / square
            for i in range(k + 1, n):
                c = re[i, k] * a - im[i, k] * b
                d = re[i, k] * b + im[i, k] * a
                for j in range(k + 1, n + 2):
                    re[i, j] -= c * re[k, j] - d * im[k, j]
                    im[i, j] -= c * im[k, j] + d * re[k, j]
        for column in range(2):
            found = unit[r] if column == 0 else free[r]
            answer = 0.0
            for i in range(n - 1, -1, -1):
                total = complex(re[i, n + column], im[i, n + column])
                for j in range(i + 1, n):
                    total -= complex(re[i, j], im[i, j]) * found[j]
                found[i] = total / complex(re[i, i], im[i, i])
                answer = max(answer, abs(found[i]) * root[i])
            given = 1.0 / root[joint] if column == 0 else size
            if given > 0.0 and not answer * stiffness <= limit * given:
                return unit, free, r
    return unit, free, -1
