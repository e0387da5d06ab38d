"""Writing a response to a netCDF file.

Depends on: dataset (through the response); io.files.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsim.io.files import whole_file

if TYPE_CHECKING:
    from beltsim.response import Response


def save(response: Response, path: str | Path, inputs: Mapping[str, Any] | None = None) -> Path:
    """Write `response` to `path` as netCDF, whole or not at all.

    Parameters
    ----------
    response : Response
        Of any solver.
    path : str or Path
        File to write; replaced if it exists. Its folder must exist.
    inputs : mapping, optional
        What the run was started with, such as the text of the drive file and the arguments:
        anything JSON holds. `stored_inputs` gives it back.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    ResultFileError
        When the file cannot be written; nothing is left behind then.

    Examples
    --------
    >>> import tempfile, beltsim
    >>> from beltsim.transient import integrate
    >>> forcing = beltsim.HarmonicForcing(1.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    >>> law = beltsim.Coulomb(0.2)
    >>> problem = beltsim.FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, forcing, law)
    >>> file = save(integrate(problem, periods=2), tempfile.mkdtemp() + "/result.nc")
    >>> beltsim.load(file).problem.friction
    Coulomb(Q_m=0.2, Q_s=0.2)
    """
    data = response.to_xarray()
    data.attrs["inputs"] = json.dumps(dict(inputs or {}), ensure_ascii=False)
    return save_dataset(data, path)


def save_dataset(data: Any, path: str | Path) -> Path:
    """Write an xarray dataset to `path` as netCDF, whole or not at all.

    Raises
    ------
    ResultFileError
        When the file cannot be written; nothing is left behind then.
    """
    target = Path(path)
    content = _netcdf(data)
    with whole_file(target) as temporary:
        temporary.write_bytes(content)
    return target


def _netcdf(data: Any) -> bytes:
    """The dataset as the bytes of a netCDF 4 file.

    Made in memory, since HDF5 crashes the process when the disk refuses it a byte.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    # a fill value would turn a true NaN into "missing" for other readers
    plain = {name: {"_FillValue": None} for name, one in data.variables.items() if _is_float(one)}
    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        data.dump_to_store(H5NetCDFStore(file), encoding=plain)
    return buffer.getvalue()


def _is_float(variable: Any) -> bool:
    return bool(variable.dtype.kind == "f")
