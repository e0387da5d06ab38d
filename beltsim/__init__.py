"""beltsim: serpentine belt drives whose tensioner arm rubs on its pivot.

Drive -> DimensionlessDrive -> OperatingPoint -> SteadyState -> LinearSystem -> FrictionProblem
-> {linear, event_map, transient, harmonic_balance} -> Response -> metrics -> leaves.

Names are loaded when they are first used, so `import beltsim` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "FrictionProblem": "beltsim.problem",
    "Observable": "beltsim.problem",
    "Scales": "beltsim.problem",
    "HarmonicForcing": "beltsim.forcing",
    "Coulomb": "beltsim.friction",
    "SaturatedCoulomb": "beltsim.friction",
    "Response": "beltsim.response",
    "EventLog": "beltsim.response",
    "Drive": "beltsim.drive",
    "load_drive": "beltsim.drive",
    "assemble": "beltsim.model",
    "load": "beltsim.io",
}
_MODULES = (
    "cross_check",
    "drive",
    "errors",
    "event_map",
    "harmonic_balance",
    "io",
    "linear",
    "metrics",
    "model",
    "plots",
    "presets",
    "study",
    "transient",
)

__all__ = [*_HOME, *_MODULES, "__version__"]  # noqa: PLE0604 - keys are strings


def __getattr__(name: str) -> Any:
    if name == "presets":
        return importlib.import_module("beltsim.drive.presets")
    if name in _MODULES:
        return importlib.import_module(f"beltsim.{name}")
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'beltsim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
