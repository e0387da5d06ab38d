"""The other solver: exact motion from eigenvectors.

No import from beltsim: see exact_modal.py in this family.
"""

from validation.cross_method import exact_modal

__all__ = ["exact_modal"]
