"""The other solver, exact, and what controlling the error of a step does to that of a run.

A method of order k makes an error C h^(k+1) in a step, which is held at rtol, so the steps are
h ~ rtol^(1/(k+1)), and the errors of 1/h steps add up to rtol^(k/(k+1)). BDF goes up to order 5,
and uses it at tight tolerances; Adams moves between about 4 and 12, the middle of 4/5 and 12/13.

No import from beltsim: see exact_modal.py in this family.
"""

from validation.cross_method import exact_modal

EXPONENTS = {"adams": 0.86, "bdf": 5 / 6}

__all__ = ["EXPONENTS", "exact_modal"]
