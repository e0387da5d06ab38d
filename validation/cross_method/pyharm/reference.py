"""The peer: pyHarm-os. No import from beltsim: see peer_pyharm.py in this family."""

from validation.cross_method import peer_pyharm

__all__ = ["peer_pyharm"]
