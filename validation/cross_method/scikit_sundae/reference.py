"""The judge, an exact motion from eigenvectors, and the peer, scikit-sundae.

No import from beltsim: see exact_modal.py and peer_sundae.py in this family.
"""

from validation.cross_method import exact_modal, peer_sundae

__all__ = ["exact_modal", "peer_sundae"]
