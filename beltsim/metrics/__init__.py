"""Quantities that engineers read off a drive or a response, one per module.

rms, span_rms, span_tensions, hub_loads, resonances, phase_pattern, survey

Depends on: model, problem, response, drive, linear.
"""

from beltsim.metrics.resonances import Resonance, resonances
from beltsim.metrics.survey import Survey, survey

__all__ = ["Resonance", "Survey", "resonances", "survey"]
