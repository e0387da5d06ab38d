"""Root mean squares from samples and from harmonics."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem
from support.responses import stick_slip

import beltsim
from beltsim import linear
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidProblemError
from beltsim.metrics.rms import rms, rms_of_coefficients, rms_of_samples
from beltsim.metrics.span_rms import sines_of, span_rms, span_rms_m

PROBLEM = beltsim.assemble(zhu_parker_2008(), 6.3, n_functions=[2, 4, 3])


def series(c, x):
    return (np.exp(1j * np.multiply.outer(x, np.arange(len(c)))) @ c).real


def test_samples_and_harmonics_agree():
    rng = np.random.default_rng(0)
    c = rng.normal(size=(6, 3)) + 1j * rng.normal(size=(6, 3))
    c[0] = c[0].real
    t = np.linspace(0.0, 2.0 * np.pi, 65)
    assert rms_of_samples(t, series(c, t)) == pytest.approx(rms_of_coefficients(c), rel=1e-12)
    # events make samples unequal: still an integral over time, not a mean over samples
    t = np.sort(np.concatenate([np.linspace(0.0, 2.0 * np.pi, 20001), rng.uniform(0, 1, 20000)]))
    assert rms_of_samples(t, series(c, t)) == pytest.approx(rms_of_coefficients(c), rel=1e-6)


def test_known_values():
    assert rms_of_coefficients(np.array([3.0, 4.0 * np.sqrt(2.0)])) == pytest.approx(5.0)
    assert rms_of_samples([0.0, 1.0, 4.0], [2.0, 2.0, 2.0]) == pytest.approx(2.0)


def test_a_response_is_measured_by_its_harmonics_where_it_has_them():
    harmonics = np.array([[0.3, -0.1], [4.0j, 1.0 + 1.0j]])
    run, orbit = stick_slip(), stick_slip(coefficients=harmonics)
    assert run.coefficients is None
    assert rms(run) == pytest.approx(rms_of_samples(run.t, run.q))
    assert rms(run)[0] == pytest.approx(0.003 / np.sqrt(2.0), rel=1e-4)
    assert rms(orbit) == pytest.approx([np.hypot(0.3, np.sqrt(8.0)), np.hypot(0.1, 1.0)])


def test_span_rms_is_the_deflection_averaged_along_the_span_and_over_time():
    """Eq. 24 by brute force on a grid of places and times."""
    c = linear.response(PROBLEM)
    found = span_rms(PROBLEM, rms_of_coefficients(c))
    tau = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    x = (np.arange(400) + 0.5) / 400
    for i, sines in enumerate(sines_of(PROBLEM)):
        a = series(c[:, sines], tau)
        y = a @ np.sin(np.pi * np.multiply.outer(np.arange(1, len(sines) + 1), x))
        assert found[i] == pytest.approx(np.sqrt(np.mean(y**2)), rel=1e-9)
    lengths = [0.1548, 0.3449, 0.5518]
    assert span_rms_m(PROBLEM, rms_of_coefficients(c)) == pytest.approx(found * lengths)


def test_sines_are_found_by_their_labels():
    assert [len(sines) for sines in sines_of(PROBLEM)] == [2, 4, 3]
    with pytest.raises(InvalidProblemError, match=r"labels = .*an assembled drive"):
        sines_of(random_problem(0, 3))
