"""The exact event map: transients and periodic orbits of a Coulomb joint, to rounding.

Depends on: problem, forcing, friction, response, and the extension `beltsim._event_map`.
"""

from __future__ import annotations

from beltsim.event_map.orbit import periodic as periodic
from beltsim.event_map.propagate import propagate as propagate
from beltsim.event_map.settings import Settings as Settings
