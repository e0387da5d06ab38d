"""What all problems of a grid share is refused once, not once for each of them."""

import pytest

from beltsim import (
    Coulomb,
    FrictionProblem,
    HarmonicForcing,
    cross_check,
    event_map,
    harmonic_balance,
    transient,
)
from beltsim.errors import InvalidProblemError

PUSH = HarmonicForcing(0.5, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
GRID = [
    FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[1.0]], 0, PUSH, Coulomb(Q)) for Q in (0.2, 0.6)
]


@pytest.mark.parametrize("function", [event_map.solve_many, event_map.survey])
def test_event_map(function):
    with pytest.raises(InvalidProblemError, match=r"settings = .*event_map.Settings"):
        function(GRID, "quick")


@pytest.mark.parametrize("solver", [event_map, harmonic_balance])
def test_what_is_no_grid(solver):
    for function in (solver.solve_many, solver.survey):
        with pytest.raises(InvalidProblemError, match="a sequence of FrictionProblem"):
            function(GRID[0])
        with pytest.raises(InvalidProblemError, match=r"problems\[1\] = 3"):
            function([GRID[0], 3])


@pytest.mark.parametrize(
    "function",
    [
        event_map.periodic,
        event_map.propagate,
        harmonic_balance.solve,
        transient.integrate,
        cross_check.check,
    ],
)
def test_what_is_no_problem(function):
    with pytest.raises(InvalidProblemError, match="problem = 3: must be a FrictionProblem"):
        function(3)


@pytest.mark.parametrize("function", [harmonic_balance.solve_many, harmonic_balance.survey])
def test_harmonic_balance(function):
    with pytest.raises(InvalidProblemError, match=r"settings = 9.*harmonic_balance.Settings"):
        function(GRID, 9)
    with pytest.raises(InvalidProblemError, match=r"R = 0"):
        function(GRID, R=0)
