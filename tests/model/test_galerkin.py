"""Matrices: symmetry to the last bit, the zero mode, energy, and convergence in the sines."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from support.layouts import drives, random_drive

from beltsim import linear
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidProblemError
from beltsim.model import assemble, chain, crank, galerkin

PAPER = zhu_parker_2008()


@settings(derandomize=True, deadline=None, max_examples=15)
@given(drives())
def test_symmetry_is_exact(drive):
    problem = assemble(drive, n_functions=9)
    full = crank.release(chain(drive, n_functions=9).system)
    for system in (problem, full):
        assert np.array_equal(system.M, system.M.T)
        assert np.array_equal(system.K, system.K.T)
        assert np.array_equal(system.G, -system.G.T)
    assert np.array_equal(problem.C, problem.C.T)
    assert np.linalg.eigvalsh(problem.M)[0] > 0.0
    assert np.linalg.eigvalsh(problem.K)[0] > 0.0


@settings(derandomize=True, deadline=None, max_examples=10)
@given(drives())
def test_the_full_system_has_one_zero_mode(drive):
    """All pulleys roll with the belt: r_j theta_j equal, nothing else moves."""
    full = crank.release(chain(drive, n_functions=6).system)
    rolling = np.array(
        [
            1.0 / {p.name: p.radius_m for p in drive.pulleys}[label.removeprefix("theta_")]
            if label.startswith("theta_") and label != "theta_t"
            else 0.0
            for label in full.coordinates.labels
        ]
    )
    size = np.abs(full.K).max() * np.abs(rolling).max()
    assert np.abs(full.K @ rolling).max() < 1e-14 * size
    values = np.linalg.eigvalsh(full.K)
    assert abs(values[0]) < 1e-12 * values[-1]
    assert values[1] > 1e-9 * values[-1]


@pytest.mark.parametrize("free_crank", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_energy_of_the_undamped_free_drive_is_conserved(seed, free_crank):
    """The exact motion of M, G, K: gyroscopic forces do no work."""
    system = chain(random_drive(np.random.default_rng(seed), 4), n_functions=4)
    if free_crank:
        system = crank.release(system.system)
    M, G, K = system.M, system.G, system.K
    n = len(M)
    right = np.linalg.solve(M, np.hstack([K, G]))
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-right]])
    start = np.random.default_rng(seed).normal(size=2 * n) * 0.01

    def energy(state):
        q, q_dot = state[:n], state[n:]
        return 0.5 * (q_dot @ M @ q_dot + q @ K @ q)

    assert np.abs(G).max() > 0.01 * np.abs(M).max()
    for time in (0.3, 2.0, 10.0):
        moved = scipy.linalg.expm(first_order * time) @ start
        assert abs(energy(moved) / energy(start) - 1.0) < 1e-9
        assert np.abs(moved - start).max() > 1e-3


def test_residual_flexibility_is_the_static_condensation_of_the_sines_left_out():
    kept, many = 6, 400
    long = chain(PAPER, 6.3, n_functions=many, residual_flexibility=False)
    labels = long.coordinates.labels
    out = np.array([".sin" in x and int(x.partition(".sin")[2]) > kept for x in labels])
    K = long.K
    coupling = K[np.ix_(~out, out)]
    condensed = K[np.ix_(~out, ~out)] - coupling @ np.linalg.solve(K[np.ix_(out, out)], coupling.T)
    short = chain(PAPER, 6.3, n_functions=kept)
    assert np.abs(short.K - condensed).max() < 1e-8 * np.abs(K).max()
    plain = chain(PAPER, 6.3, n_functions=kept, residual_flexibility=False)
    assert np.abs(plain.K - condensed).max() > 1e-3 * np.abs(condensed).max()


def first_ten(Omega, n, residual_flexibility=True, drive=PAPER):
    problem = assemble(drive, Omega, n_functions=n, residual_flexibility=residual_flexibility)
    return linear.frequencies(problem)[:10]


@pytest.mark.parametrize(
    ("Omega", "limit"), [(0.5, 1e-3), (3.3, 1e-3), (6.3, 1e-3), (9.0, 2e-3), (12.0, 2e-3)]
)
def test_sixteen_sines_are_enough(Omega, limit):
    assert np.abs(first_ten(Omega, 16) / first_ten(Omega, 80) - 1.0).max() < limit


def test_rates_of_convergence():
    """Beyond the boundary layer (here 1/(pi delta) is about 3 to 10 sines) the error falls as N^-5.

    The work of a sine on the steady slope falls as 1/k and its stiffness grows as k^4, so what the
    tail takes sums to N^-5. The residual flexibility takes the static part of it away; what the
    gyroscopic coupling of the tail does stays, with the same power and a smaller factor.
    """
    stiff = zhu_parker_2008(epsilon=0.05)
    exact = first_ten(6.3, 160, drive=stiff)
    counts = np.array([20, 28, 40, 56])
    errors = {
        on: np.array(
            [np.abs(first_ten(6.3, n, on, stiff) / exact - 1.0).max() for n in counts.tolist()]
        )
        for on in (True, False)
    }
    for on, slowest in ((True, -4.7), (False, -4.4)):
        rate = np.polyfit(np.log(counts), np.log(errors[on]), 1)[0]
        assert -5.5 < rate < slowest, on
    assert (errors[True] < 0.25 * errors[False]).all()


@pytest.mark.parametrize(
    "given", [0, -1, 2001, 1.5, "8", True, [4, 5], [4, 5, 0], [4, 5, 5.0], None]
)
def test_numbers_of_sines_that_cannot_be(given):
    with pytest.raises(InvalidProblemError, match=r"n_functions = .*one for each of the 3 spans"):
        assemble(PAPER, 6.3, n_functions=given)


def test_one_number_of_sines_per_span_follows_the_users_order():
    for travel in ("cw", "ccw"):
        drive = random_drive(np.random.default_rng(2), 4, travel)
        problem = assemble(drive, n_functions=[1, 2, 3, 4])
        expected = [f"span{i}.sin{k}" for i in (1, 2, 3, 4) for k in range(1, i + 1)]
        assert list(problem.labels[:10]) == expected


def test_the_basis_is_built_once_and_frozen():
    scaled = chain(PAPER, 6.3).drive
    assert galerkin.basis_of(scaled, 16) is galerkin.basis_of(scaled, [16, 16, 16])
    for value in vars(galerkin.basis_of(scaled, 16)).values():
        assert not value.flags.writeable
