"""Den Hartog's closed form, as derived for the transients' case."""

from validation.analytic.den_hartog import reference as closed_form

CASES = closed_form.CASES
steady = closed_form.steady
