"""The exact event map: transients and periodic orbits of a Coulomb joint, to rounding.

Depends on: problem, forcing, friction, response, and the extension `beltsim._event_map`.
"""

from __future__ import annotations

from beltsim.event_map.many import solve_many as solve_many
from beltsim.event_map.orbit import periodic as periodic
from beltsim.event_map.orbit import rms as rms
from beltsim.event_map.propagate import propagate as propagate
from beltsim.event_map.settings import Settings as Settings
from beltsim.event_map.survey import Survey as Survey
from beltsim.event_map.survey import survey as survey
