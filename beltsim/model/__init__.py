"""From a drive to the friction problem, one noun per module.

scaling -> operating_point -> steady_state -> galerkin -> crank -> modal -> assemble

Depends on: drive, problem, forcing, friction.
"""

from beltsim.model.assemble import assemble, assemble_driven, chain, friction_of

__all__ = ["assemble", "assemble_driven", "chain", "friction_of"]
