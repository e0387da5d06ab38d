"""The slope of an error over a resolution, both on logarithmic scales.

Depends on: nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def slope(resolution: Any, errors: Any) -> float:
    """Exponent p of errors ~ resolution^p by least squares, for positive arrays of one shape."""
    return float(np.polyfit(np.log(resolution), np.log(errors), 1)[0])
