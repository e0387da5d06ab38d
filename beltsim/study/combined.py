"""`combined`: the same study by several methods, side by side in one dataset.

Depends on: xarray.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


def combined(parts: Mapping[Any, Any], dimension: str) -> Any:
    """One dataset from several, along a new first dimension.

    Parameters
    ----------
    parts : mapping
        A dataset for each value of the dimension. Coordinates must be the same but for
        `coordinate`, of which those that all parts have are kept.
    dimension : str
        Such as ``"solver"`` or ``"R"``.

    Returns
    -------
    xarray.Dataset
        Global attributes are those that all parts share; the others become variables over
        `dimension`.

    Examples
    --------
    >>> import beltsim
    >>> from beltsim.study import EventMap, HarmonicBalance, sweep
    >>> drive = beltsim.presets.zhu_parker_2008()
    >>> methods = {"exact": EventMap(), "R = 9": HarmonicBalance(9)}
    >>> both = {name: sweep(drive, [6.3], [3.5], m, n_functions=6) for name, m in methods.items()}
    >>> found = combined(both, "solver")
    >>> found.stick_fraction.dims, found.solver.values.tolist()
    (('solver', 'Omega', 'Q_m'), ['exact', 'R = 9'])
    """
    import xarray

    names, sets = list(parts), list(parts.values())
    if all("coordinate" in one.dims for one in sets):
        shared = [
            label
            for label in sets[0].coordinate.values.tolist()
            if all(label in one.coordinate.values for one in sets)
        ]
        sets = [one.sel(coordinate=shared) for one in sets]
    same = {k: v for k, v in sets[0].attrs.items() if all(one.attrs.get(k) == v for one in sets)}
    differing = sorted({key for one in sets for key in one.attrs} - set(same))
    joined = xarray.concat(
        [_bare(one) for one in sets],
        xarray.DataArray(np.array(names), dims=[dimension], name=dimension),
        join="exact",
        data_vars="all",
        coords="minimal",
        compat="equals",
    )
    for key in differing:
        values = [str(one.attrs.get(key, "")) for one in sets]
        joined[key] = (dimension, np.array(values, dtype=np.str_))
    return joined.assign_attrs(same)


def _bare(data: Any) -> Any:
    """A copy without global attributes."""
    copy = data.copy()
    copy.attrs = {}
    return copy
