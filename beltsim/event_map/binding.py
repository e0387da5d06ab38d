"""The C map, and one clear error where it was not built.

Depends on: the extension `beltsim._event_map`.
"""

from __future__ import annotations

try:
    from beltsim import _event_map
except ImportError as error:
    text = (
        "the exact event map was not built with this installation (beltsim._event_map is missing); "
        "install from a wheel, or build with a C compiler: pip install ."
    )
    raise ImportError(text) from error

changes_reals = _event_map.changes_reals
flow_reals = _event_map.flow_reals
gram = _event_map.gram
orbit = _event_map.orbit
prepare = _event_map.prepare
propagate = _event_map.propagate
