"""The C map with SciPy's LAPACK, and one clear error where it was not built.

Depends on: checks, the extension `beltsim._event_map`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import cython_lapack as lapack

from beltsim.checks import FloatArray

try:
    from beltsim import _event_map
except ImportError as error:
    text = (
        "the exact event map was not built with this installation (beltsim._event_map is missing); "
        "install from a wheel, or build with a C compiler: pip install ."
    )
    raise ImportError(text) from error

_event_map.use_lapack(*(lapack.__pyx_capi__[name] for name in ("dgeev", "dgesv", "zgesv")))

changes = _event_map.changes
changes_reals = _event_map.changes_reals
flow_reals = _event_map.flow_reals
fourier = _event_map.fourier
integrals = _event_map.integrals
modes = _event_map.modes
orbit = _event_map.orbit
propagate = _event_map.propagate
sample = _event_map.sample


def pairs(x: Any) -> FloatArray:
    """Complex array as the reals of the C map: real and imaginary part next to each other."""
    found: FloatArray = np.ascontiguousarray(x, dtype=complex).view(float)
    return found
