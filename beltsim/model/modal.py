r"""Modal damping of the free-arm system.

With :math:`K_0\Phi = M_0\Phi\,\mathrm{diag}(\omega^2)`, :math:`\Phi^T M_0 \Phi = 1` (crank removed,
gyroscopic terms left out), every mode gets the same damping ratio:

.. math:: C_0 = M_0 \Phi\,\mathrm{diag}(2\zeta\omega)\,\Phi^T M_0

It is built once per speed. A locked arm uses the same matrix without the arm's row and column.

Depends on: checks, errors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import SteadyStateError


class MassFactor(NamedTuple):
    """Cholesky factor L of a mass matrix, M = L L', and its inverse."""

    L: FloatArray
    L_inverse: FloatArray


def mass_factor(M: FloatArray) -> MassFactor:
    """Cholesky factor of a positive definite `M` (n, n) and its inverse."""
    L = np.linalg.cholesky(M)
    return MassFactor(np.asarray(L), np.asarray(np.linalg.inv(L)))


def damping(
    M: FloatArray, K: FloatArray, zeta: float, factor: MassFactor | None = None
) -> FloatArray:
    """Damping matrix that gives every mode of (M, K) the ratio `zeta`.

    Parameters
    ----------
    M, K : (n, n)
        Symmetric; M positive definite, K positive semidefinite.
    zeta : float
        Damping ratio, >= 0.
    factor : MassFactor, optional
        That of M, where it is known already.

    Returns
    -------
    (n, n)
        Symmetric to the last bit.

    Raises
    ------
    SteadyStateError
        When K has a negative eigenvalue.

    Examples
    --------
    >>> damping(np.eye(1), np.array([[4.0]]), 0.05)
    array([[0.2]])
    """
    if zeta == 0.0:
        return np.zeros_like(M)
    L, L_inverse = factor or mass_factor(M)
    squares, V = np.linalg.eigh(L_inverse @ K @ L_inverse.T)
    if squares[0] < -1e-9 * squares[-1]:
        message = (
            f"stiffness has a negative eigenvalue ({squares[0]:.3g}): the steady state would "
            "buckle; raise the initial tension or lower the speed"
        )
        raise SteadyStateError(message)
    frequencies = np.sqrt(np.maximum(squares, 0.0))
    modes = (L @ V) * np.sqrt(2.0 * zeta * frequencies)
    found: FloatArray = modes @ modes.T
    return found
