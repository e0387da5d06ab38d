"""The waist: what a friction problem accepts, refuses, and turns into."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.problems import problems, random_problem

import beltsim
from beltsim.errors import InvalidProblemError
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem, Observable, Scales

M = np.array([[2.0, 0.3], [0.3, 1.0]])
C = np.array([[0.2, 0.0], [0.0, 0.1]])
G = np.array([[0.0, 0.4], [-0.4, 0.0]])
K = np.array([[5.0, -1.0], [-1.0, 3.0]])
FORCING = HarmonicForcing(1.5, [[0.0, 0.0], [1.0, 0.5]], np.zeros((2, 2)))
SEEN = Observable("tension", [1.0, -2.0], [0.5, 1.0], [0.0, 2.0], lower=0.0)
SCALES = Scales(1e-3, 30.0, [0.1, 1.0], ("m", "rad"))


def build(**changes):
    data = {"M": M, "C": C, "G": G, "K": K, "joint": 1, "forcing": FORCING}
    return FrictionProblem(**(data | {"friction": Coulomb(0.5)} | changes))


def mistakes(**changes):
    with pytest.raises(InvalidProblemError) as caught:
        build(**changes)
    return caught.value.mistakes


def test_a_valid_problem_is_taken_as_it_is():
    problem = build(joint=np.int64(1), scales=SCALES, observables=[SEEN], warnings=["slack"])
    assert problem.n == 2
    assert problem.period == FORCING.period
    assert type(problem.joint) is int
    assert problem.labels == ("q0", "q1")
    assert problem.observables == (SEEN,)
    assert problem.warnings == ("slack",)
    for name, matrix in zip("MCGK", (M, C, G, K), strict=True):
        assert np.array_equal(getattr(problem, name), matrix)


def test_lists_and_integers_are_matrices_too():
    problem = FrictionProblem(
        [[2]], [[0]], [[0]], [[4]], 0, HarmonicForcing(1, [[1]], [[0]]), Coulomb(1)
    )
    assert problem.K.dtype == np.float64


def test_frozen():
    mine = M.copy()
    problem = build(M=mine)
    mine[0, 0] = 99.0
    assert problem.M[0, 0] == 2.0
    for name in "MCGK":
        with pytest.raises(ValueError, match="read-only"):
            getattr(problem, name)[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        problem.joint = 0
    with pytest.raises(ValueError, match="read-only"):
        SEEN.row[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        SCALES.coordinates[0] = 1.0


def test_a_copy_through_pickle_is_the_same_problem():
    copy = pickle.loads(pickle.dumps(build()))
    assert np.array_equal(copy.K, K)
    assert copy.friction == Coulomb(0.5)


@pytest.mark.parametrize("name", ["M", "C", "G", "K"])
@pytest.mark.parametrize(
    "bad",
    [
        *(None, 3.0, [1.0, 2.0], [[1.0, 2.0]], [[1.0], [2.0, 3.0]], [["a", "b"], ["c", "d"]]),
        *(np.full((2, 2), np.nan), [[1.0, np.inf], [np.inf, 1.0]], np.eye(2) > 0, 1j * np.eye(2)),
        np.zeros((2, 2, 2)),
    ],
)
def test_each_matrix_must_be_square_and_finite(name, bad):
    found = mistakes(**{name: bad})
    assert [mistake.field for mistake in found] == [name]
    assert "finite array of shape (n, n)" in str(found[0])
    assert "\n" not in str(found[0])


@pytest.mark.parametrize("name", ["C", "G", "K"])
def test_each_matrix_must_have_the_size_of_M(name):
    (found,) = mistakes(**{name: np.zeros((3, 3))})
    assert str(found) == f"{name} = 'shape (3, 3)': must be of shape (2, 2), as M"


@pytest.mark.parametrize(
    ("name", "matrix", "word"),
    [("M", M, "symmetric"), ("C", C, "symmetric"), ("K", K, "symmetric"), ("G", G, "skew")],
)
def test_symmetry_beyond_rounding(name, matrix, word):
    size = np.abs(matrix).max()
    slightly, clearly = matrix.copy(), matrix.copy()
    slightly[0, 1] += 0.5e-12 * size
    clearly[0, 1] += 2e-12 * size
    build(**{name: slightly})
    (found,) = mistakes(**{name: clearly})
    assert found.field == name
    assert word in found.allowed


def test_G_with_a_diagonal_is_not_skew():
    (found,) = mistakes(G=np.eye(2))
    assert (found.field, found.value) == ("G", "asymmetry 2")


@pytest.mark.parametrize(
    ("bad", "value"),
    [
        ([[1.0, 2.0], [2.0, 1.0]], "smallest scaled eigenvalue -1"),
        ([[-1.0, 0.0], [0.0, 1.0]], "diagonal entry -1"),
        ([[1.0, 0.0], [0.0, 0.0]], "diagonal entry 0"),
        (np.zeros((2, 2)), "diagonal entry 0"),
    ],
)
def test_M_must_be_positive_definite(bad, value):
    (found,) = mistakes(M=bad)
    assert str(found) == f"M = {value!r}: must be positive definite"


def test_M_must_be_well_conditioned_whatever_the_units():
    build(M=np.diag([1e-12, 1e12]), C=np.zeros((2, 2)))
    (found,) = mistakes(M=[[1.0, 1.0], [1.0, 1.0 + 1e-12]])
    assert found.field == "M"
    assert found.value.startswith("condition ")
    assert found.allowed == "at most 1e+12"


def test_C_may_be_zero_or_semidefinite():
    build(C=np.zeros((2, 2)))
    build(C=[[1.0, 1.0], [1.0, 1.0]])


@pytest.mark.parametrize(
    "bad", [-1e-3 * np.eye(2), [[0.0, 0.1], [0.1, 0.0]], np.diag([1.0, -1e-9])]
)
def test_C_must_not_feed_energy_in(bad):
    (found,) = mistakes(C=bad)
    assert found.field == "C"
    assert found.allowed == "positive semidefinite"


def test_negative_damping_is_seen_whatever_the_units():
    """A coordinate in micrometres has 1e12 times the damping of one in metres."""
    found = mistakes(M=np.diag([1e12, 1.0]), C=np.diag([1e12, -1e-3]))
    assert [mistake.field for mistake in found] == ["C"]


@pytest.mark.parametrize("bad", [True, False, np.True_, 1.0, np.float64(1), "1", [1], 1j])
def test_joint_must_be_an_integer(bad):
    (found,) = mistakes(joint=bad)
    assert (found.field, found.allowed) == ("joint", "an integer index or None")


@pytest.mark.parametrize("bad", [-1, 2, 10**9])
def test_joint_must_be_in_range(bad):
    (found,) = mistakes(joint=bad)
    assert str(found) == f"joint = {bad}: must be between 0 and 1"


@pytest.mark.parametrize("bad", [None, 0.5, "coulomb", Coulomb])
def test_a_joint_needs_a_law(bad):
    (found,) = mistakes(friction=bad)
    assert (found.field, found.allowed) == ("friction", "Coulomb or SaturatedCoulomb")


def test_no_joint_no_law():
    assert build(joint=None, friction=None).joint is None
    (found,) = mistakes(joint=None)
    assert (found.field, found.allowed) == ("friction", "None, since joint is None")


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"forcing": None}, "forcing"),
        ({"forcing": HarmonicForcing(1.0, [[0.0]], [[0.0]])}, "forcing.cos"),
        ({"labels": ("a",)}, "labels"),
        ({"labels": "ab"}, "labels"),
        ({"labels": (1, 2)}, "labels"),
        ({"scales": 2.0}, "scales"),
        ({"scales": Scales(1.0, 1.0, [1.0], ("m", "rad"))}, "scales.coordinates"),
        ({"scales": Scales(1.0, 1.0, [1.0, 1.0], ("m",))}, "scales.units"),
        ({"observables": ["tension"]}, "observables[0]"),
        ({"observables": [SEEN, dataclasses.replace(SEEN, row=[1.0])]}, "observables[1].row"),
        ({"observables": [dataclasses.replace(SEEN, sin=[0.0])]}, "observables[0]"),
    ],
)
def test_companions_must_fit(change, field):
    assert [mistake.field for mistake in mistakes(**change)] == [field]


def test_all_mistakes_at_once():
    found = mistakes(
        M=[[1.0, 2.0], [2.0, 1.0]], G=np.eye(2), K=[[1.0]], joint=7, friction=None, labels=("a",)
    )
    fields = [mistake.field for mistake in found]
    assert sorted(fields) == ["G", "K", "M", "friction", "joint", "labels"]


@pytest.mark.parametrize("field", ["M", "C", "G", "K"])
@given(data=st.data())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_one_bad_entry_anywhere_is_found(field, data):
    problem = data.draw(problems(max_n=6))
    i, j = (data.draw(st.integers(0, problem.n - 1)) for _ in range(2))
    bad = np.array(getattr(problem, field))
    bad[i, j] = data.draw(st.sampled_from([np.nan, np.inf, -np.inf]))
    with pytest.raises(InvalidProblemError) as caught:
        dataclasses.replace(problem, **{field: bad})
    assert [mistake.field for mistake in caught.value.mistakes] == [field]


def test_checks_factor_each_matrix_once(monkeypatch):
    """Cost guard: a factor of M, C and K each, no eigenvalues.

    A condition number only where M is nearly singular: the determinant of the scaled M bounds its
    condition, and settles the usual case.
    """
    calls = dict.fromkeys(("cholesky", "cond", "eigvalsh", "eigh", "eigvals", "svd"), 0)

    def counted(name, inner):
        def call(*args, **kwargs):
            calls[name] += 1
            return inner(*args, **kwargs)

        return call

    for name in calls:
        monkeypatch.setattr(np.linalg, name, counted(name, getattr(np.linalg, name)))
    problem = random_problem(0, 5)
    calls.update(dict.fromkeys(calls, 0))
    dataclasses.replace(problem)
    expected = dict.fromkeys(calls, 0) | {"cholesky": 3}
    assert calls == expected
    problem.with_friction(Coulomb(1.0))
    assert calls == expected
    nearly = 1.0 - 1e-11
    FrictionProblem([[1.0, nearly], [nearly, 1.0]], C, G, K, 1, FORCING, Coulomb(0.5))
    assert calls["cond"] == 1


def test_blocks():
    problem = random_problem(1, 4)
    j, keep = problem.joint, problem.others
    assert sorted([*keep, j]) == [0, 1, 2, 3]
    assert np.array_equal(problem.block("M", "q", "q"), problem.M[np.ix_(keep, keep)])
    assert np.array_equal(problem.block("C", "q", "t")[:, 0], problem.C[keep, j])
    assert np.array_equal(problem.block("G", "t", "q")[0], problem.G[j, keep])
    assert problem.block("K", "t", "t").tolist() == [[problem.K[j, j]]]


def test_freed():
    problem = build(scales=SCALES, observables=[SEEN], labels=("a", "b"), warnings=("w",))
    free = problem.freed()
    assert (free.joint, free.friction, free.n) == (None, None, 2)
    assert (free.labels, free.scales, free.warnings) == (("a", "b"), SCALES, ("w",))
    assert np.array_equal(free.others, [0, 1])


def test_locked():
    problem = build(joint=0, scales=SCALES, observables=[SEEN], labels=("a", "b"), warnings=("w",))
    held = problem.locked()
    assert (held.joint, held.friction, held.n) == (None, None, 1)
    for name in "MCGK":
        assert getattr(held, name).tolist() == [[getattr(problem, name)[1, 1]]]
    assert held.forcing.cos.tolist() == [[0.0], [0.5]]
    assert held.forcing.Omega == FORCING.Omega
    assert (held.labels, held.warnings) == (("b",), ("w",))
    assert (held.scales.coordinates.tolist(), held.scales.units) == ([1.0], ("rad",))
    assert held.observables[0].row.tolist() == [-2.0]
    assert held.observables[0].lower == 0.0


def test_a_lone_joint_locked_leaves_nothing():
    problem = random_problem(3, 1)
    assert problem.locked().n == 0
    assert problem.locked().forcing.cos.shape == (problem.forcing.n_harmonics + 1, 0)


def test_locking_needs_a_joint():
    with pytest.raises(InvalidProblemError, match="joint = None: must be an index, to lock it"):
        build().freed().locked()


def test_with_friction_shares_the_matrices():
    problem = build(observables=[SEEN])
    other = problem.with_friction(SaturatedCoulomb(2.0, 1e-3))
    assert other.friction == SaturatedCoulomb(2.0, 1e-3)
    assert problem.friction == Coulomb(0.5)
    assert other.K is problem.K
    assert other.observables is problem.observables
    assert np.array_equal(other.others, problem.others)


def test_with_friction_checks_the_law_and_the_joint():
    with pytest.raises(InvalidProblemError, match=r"friction = 2\.0: must be Coulomb"):
        build().with_friction(2.0)
    with pytest.raises(InvalidProblemError, match="joint = None: must be an index, to carry"):
        build().freed().with_friction(Coulomb(1.0))


def test_an_observable_follows_state_and_forcing():
    t, q = np.array([0.0, 0.4]), np.array([[1.0, 2.0], [3.0, -1.0]])
    expected = q @ [1.0, -2.0] + 0.5 + np.cos(1.5 * t) + 2.0 * np.sin(1.5 * t)
    assert np.allclose(SEEN.at(t, q, 1.5), expected, rtol=0, atol=1e-15)


def test_an_entry_that_is_not_finite_is_named_with_its_place():
    K = np.diag(np.arange(1.0, 41.0))
    K[3, 7] = np.nan
    with pytest.raises(
        InvalidProblemError, match=r"^K = 'nan at \[3, 7\]': must be a finite array"
    ):
        FrictionProblem(np.eye(40), np.zeros((40, 40)), np.zeros((40, 40)), K, None, REST_40, None)
    with pytest.raises(InvalidProblemError, match=r"forcing.cos = 'inf at \[1, 0\] and 1 more'"):
        HarmonicForcing(1.0, [[0.0, 0.0], [np.inf, np.inf]], np.zeros((2, 2)))


REST_40 = HarmonicForcing(1.0, np.zeros((1, 40)), np.zeros((1, 40)))


def test_two_coordinates_of_one_name_are_refused():
    with pytest.raises(
        InvalidProblemError, match=r"labels = \"'a' at \[0, 1\]\": must be differen"
    ):
        build(labels=("a", "a"))


def test_its_text_is_one_short_line():
    text = repr(build(labels=("a", "b")))
    assert "n = 2" in text
    assert "joint 1 (b)" in text
    assert "Coulomb(Q_m=" in text
    assert len(text) < 200
    assert repr(build().forcing).startswith("<HarmonicForcing: Omega = ")


def test_indefinite_stiffness_warns_in_every_response():
    push = HarmonicForcing(1.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    weak = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[-1.0]], 0, push, Coulomb(5.0))
    assert "negative eigenvalue -1" in weak.warnings[0]
    assert weak.with_friction(Coulomb(6.0)).warnings == weak.warnings
    rigid = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[0.0]], 0, push, Coulomb(5.0))
    assert rigid.warnings == ()


def test_limits_of_angles_are_told_in_degrees():
    angle = Observable("angle", [1.0, 0.0], [0.0], [0.0], -0.1, 0.1, unit="rad")
    (text,) = angle.warnings(np.array([0.0, 0.2, 0.0]))
    assert text.startswith("angle exceeds 5.72958 deg 1 time in the last period, ")
    assert text.endswith("highest 11.4592 deg from the reference")
    assert SEEN.shown == (1.0, "")


def test_limit_warnings_are_those_of_each_observable():
    problem = beltsim.assemble(beltsim.presets.zhu_parker_2008(), 6.3, friction=Coulomb(1.0))
    t = np.linspace(0.0, problem.period, 50)
    q = 0.3 * np.sin(np.outer(t, np.arange(1, problem.n + 1)))
    wanted = []
    for seen in problem.observables:
        wanted += seen.warnings(seen.at(t, q, problem.forcing.Omega))
    assert wanted
    assert problem.limit_warnings(t, q) == wanted
    assert problem.limit_warnings(t[:0], q[:0]) == []
