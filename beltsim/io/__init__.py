"""Results on disk: netCDF files that carry their inputs, written whole or not at all.

`save` and `load` are exact inverses; `stored_inputs` reads what a run was started with.

Depends on: dataset, response, problem, forcing, friction, errors.
"""

from __future__ import annotations

from beltsim.io.files import require_writable, whole_file
from beltsim.io.reader import is_result_file, load, stored_inputs
from beltsim.io.writer import save, save_dataset

__all__ = [
    "is_result_file",
    "load",
    "require_writable",
    "save",
    "save_dataset",
    "stored_inputs",
    "whole_file",
]
