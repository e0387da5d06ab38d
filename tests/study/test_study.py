"""Studies hold what single calls give, in the same bits for any number of workers."""

import numpy as np
import pytest

import beltsim
from beltsim import event_map, io, linear, study
from beltsim.errors import InvalidProblemError, SteadyStateError
from beltsim.metrics.rms import rms_of_coefficients
from beltsim.metrics.span_tensions import peak_dynamic_tensions

DRIVE = beltsim.presets.zhu_parker_2008()
SMALL = {"n_functions": (2, 3, 2)}
SPEEDS, TORQUES = [2.8, 6.3], [0.0, 0.1, 3.5, 20.0, np.inf]


@pytest.fixture(scope="module")
def grid():
    return study.sweep(DRIVE, SPEEDS, TORQUES, spectra_of=["span1.sin2"], **SMALL)


def test_a_point_is_what_the_solver_gives(grid):
    problem = beltsim.assemble(DRIVE, 6.3, friction=beltsim.Coulomb(3.5), **SMALL)
    orbit = event_map.periodic(problem, event_map.Settings(harmonics=40))
    point = grid.sel(Omega=6.3, Q_m=3.5)
    for name in ("dissipated_energy", "stick_fraction", "stops_per_period"):
        assert float(point[name]) == pytest.approx(getattr(orbit, name), rel=1e-9)
    np.testing.assert_allclose(point.rms, event_map.rms(orbit), rtol=1e-9)
    assert str(point.phase_pattern.values) in ("0-0+", "-0+0", "0+0-", "+0-0")
    assert float(point.phases_per_period) == 4.0
    index = problem.labels.index("span1.sin2")
    np.testing.assert_allclose(
        point.amplitude.sel(signal="span1.sin2"), np.abs(orbit.coefficients[:16, index]), rtol=1e-7
    )
    assert np.isnan(point.reversals_of_series)


def test_peaks_of_tension_are_the_located_ones(grid):
    for Omega in SPEEDS:
        at = beltsim.assemble(DRIVE, Omega, **SMALL)
        for Q_m in TORQUES[1:-2]:
            orbit = event_map.periodic(
                at.with_friction(beltsim.Coulomb(Q_m)), event_map.Settings(harmonics=40)
            )
            located = peak_dynamic_tensions(orbit.problem, orbit.coefficients)
            found = grid.peak_dynamic_tension.sel(Omega=Omega, Q_m=Q_m)
            np.testing.assert_allclose(found, located, rtol=1e-5)


def test_the_ends_of_the_torque_scale_are_linear(grid):
    at = beltsim.assemble(DRIVE, 6.3, **SMALL)
    free, locked = linear.response(at), linear.response(at, locked=True)
    row = grid.sel(Omega=6.3)
    np.testing.assert_allclose(row.rms.sel(Q_m=0.0), rms_of_coefficients(free), rtol=1e-9)
    np.testing.assert_allclose(row.rms.sel(Q_m=np.inf), rms_of_coefficients(locked), rtol=1e-12)
    np.testing.assert_allclose(row.rms.sel(Q_m=20.0), row.rms.sel(Q_m=np.inf), atol=1e-12)
    assert row.stick_fraction.values[-2:].tolist() == [1.0, 1.0]


def test_the_same_bits_for_any_number_of_workers():
    torques = np.linspace(0.1, 10.0, 20)  # two pieces
    one, two = (study.sweep(DRIVE, [6.3], torques, workers=n, **SMALL) for n in (1, 2))
    assert one.identical(two)


@pytest.mark.parametrize(
    "method",
    [
        study.HarmonicBalance(41),
        study.HarmonicBalance(41, sigma=1e-3),
        study.EventMap(sigma=1e-3),
        study.Transient(periods=60),
        study.Transient(periods=60, sigma=1e-3),
    ],
)
def test_every_method_agrees_with_the_exact_one(method, grid):
    """To the error of 41 harmonics and of the band, about one per cent."""
    found = study.sweep(DRIVE, [6.3], [3.5], method, **SMALL)
    assert not str(found.failure.values[0, 0])
    exact = grid.sel(Omega=[6.3], Q_m=[3.5])
    np.testing.assert_allclose(found.dissipated_energy, exact.dissipated_energy, rtol=0.01)
    assert sorted(str(found.phase_pattern.values[0, 0])) == ["+", "-", "0", "0"] or method.sigma
    gap = np.abs(found.rms - exact.rms).max() / exact.rms.max()
    assert float(gap) < 0.01
    assert np.isnan(found.reversals_of_series).all() != isinstance(method, study.HarmonicBalance)


def test_a_point_that_fails_keeps_its_reason():
    """A belt faster than its critical speed has no steady state."""
    found = study.sweep(DRIVE, [6.3, 60.0], [0.5, np.inf], **SMALL)
    reasons = found.failure.values
    assert reasons[0].tolist() == ["", ""]
    assert all("critical speed" in reason for reason in reasons[1])
    assert np.isnan(found.rms.values[1]).all()
    assert np.isfinite(found.rms.values[0]).all()


def test_lowest_tensions_are_those_of_the_orbit():
    """To a sample of the series; and not known where the orbit carries no harmonics."""
    found = study.sweep(DRIVE, [6.3], [3.5, np.inf], **SMALL)
    problem = beltsim.assemble(DRIVE, 6.3, friction=beltsim.Coulomb(3.5), **SMALL)
    orbit = event_map.periodic(problem, event_map.Settings(samples_per_period=4000))
    spans = [seen.name for seen in problem.observables if seen.unit == "N"]
    lowest = [orbit.observe(name).min() for name in spans]
    np.testing.assert_allclose(found.lowest_tension.values[0, 0], lowest, atol=2e-3)
    assert found.lowest_tension.notnull().all()
    bare = study.sweep(DRIVE, [6.3], [3.5], study.EventMap(harmonics=0), **SMALL)
    assert np.isnan(bare.peak_dynamic_tension).all()


def test_figures_alone_are_those_of_the_orbits(grid):
    """The same numbers, whatever the number of workers; what needs the motion itself is NaN."""
    quick = study.EventMap(figures_only=True)
    one, two = (
        study.sweep(DRIVE, [*SPEEDS, 60.0], TORQUES, quick, workers=n, **SMALL) for n in (1, 2)
    )
    assert one.identical(two)
    assert all("critical speed" in reason for reason in one.failure.values[2])
    for name in ("rms", "span_rms", "dissipated_energy", "stick_fraction", "stops_per_period"):
        exact = grid[name].values
        np.testing.assert_allclose(one[name].values[:2], exact, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(one.velocity_reversals[:2], grid.velocity_reversals)
    assert np.isnan(one.peak_dynamic_tension.sel(Q_m=3.5)).all()
    with pytest.raises(InvalidProblemError, match="figures_only"):
        study.sweep(DRIVE, [6.3], [1.0], quick, spectra_of=["span1.sin2"], **SMALL)


def test_unstable_and_coexisting_orbits_are_told():
    """Q_m < Q_cr <= Q_s: the arm rests, but it might move."""
    found = study.sweep(DRIVE, [6.3], [0.5, 6.0, 20.0], study.EventMap(static_ratio=2.5), **SMALL)
    assert found.coexisting.values.tolist() == [[0.0, 1.0, 0.0]]
    assert 0.0 < found.largest_multiplier.values[0, 0] < 1.0
    series = study.sweep(DRIVE, [6.3], [0.5], study.HarmonicBalance(9), **SMALL)
    assert np.isnan(series.largest_multiplier).all()


def test_shares_of_the_critical_torque():
    found = study.sweep(DRIVE, SPEEDS, [0.5, 1.0001], relative=True, **SMALL)
    limits = study.critical_torques(DRIVE, SPEEDS, **SMALL).Q_cr
    np.testing.assert_allclose(found.Q_m.sel(share=0.5), 0.5 * limits, rtol=1e-12)
    assert found.stick_fraction.sel(share=1.0001).values.tolist() == [1.0, 1.0]
    assert (found.stick_fraction.sel(share=0.5) < 1.0).all()


def test_progress_reaches_one():
    shares = []
    study.sweep(DRIVE, SPEEDS, [0.5], progress=shares.append, **SMALL)
    assert shares == [0.5, 1.0]


def test_a_study_survives_the_disk(tmp_path, grid):
    import xarray

    path = io.save_dataset(grid, tmp_path / "grid.nc")
    with xarray.open_dataset(path) as back:
        assert back.load().identical(grid)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (([], [1.0]), "Omega"),
        (([-1.0], [1.0]), "Omega"),
        (([6.3], [np.nan]), "Q_m"),
        (([6.3], [-1.0]), "Q_m"),
        ((6.3, [1.0]), "Omega"),
    ],
)
def test_grids_that_cannot_be_used(arguments, word):
    with pytest.raises(InvalidProblemError, match=word):
        study.sweep(DRIVE, *arguments, **SMALL)


def test_mistakes_that_concern_every_point_are_raised():
    with pytest.raises(InvalidProblemError, match=r"span1\.sin9"):
        study.sweep(DRIVE, [6.3], [1.0], spectra_of=["span1.sin9"], **SMALL)
    with pytest.raises(SteadyStateError):
        study.sweep(DRIVE, [60.0], [1.0], **SMALL)
    with pytest.raises(SteadyStateError):
        study.critical_torques(DRIVE, [60.0], **SMALL)
    with pytest.raises(InvalidProblemError, match="Omega"):
        study.critical_torques(DRIVE, [], **SMALL)


def test_critical_torques():
    found = study.critical_torques(DRIVE, [*SPEEDS, 60.0], **SMALL)
    for i, Omega in enumerate(SPEEDS):
        at = beltsim.assemble(DRIVE, Omega, **SMALL)
        assert float(found.Q_cr[i]) == linear.critical_torque(at)
        assert float(found.crank_speed[i]) == pytest.approx(DRIVE.rpm(Omega))
    assert np.isnan(found.Q_cr[2])
    assert str(found.failure.values[2])


def test_histories_are_the_samples_of_the_orbit():
    found = study.histories(DRIVE, 6.3, [3.5], samples=100, **SMALL)
    problem = beltsim.assemble(DRIVE, 6.3, friction=beltsim.Coulomb(3.5), **SMALL)
    orbit = event_map.periodic(problem, event_map.Settings(samples_per_period=100))
    np.testing.assert_allclose(found.velocity[0], orbit.q_dot[:, -1], atol=1e-9)
    np.testing.assert_allclose(found.friction_torque[0], orbit.friction_torque, atol=1e-9)
    assert float(np.abs(found.friction_torque).max()) == pytest.approx(3.5)


def test_histories_of_a_run_are_its_last_period():
    runs = study.histories(DRIVE, 6.3, [3.5], study.Transient(periods=60), samples=100, **SMALL)
    exact = study.histories(DRIVE, 6.3, [3.5], samples=100, **SMALL)
    np.testing.assert_allclose(runs.velocity, exact.velocity, atol=1e-5)


def test_combined_keeps_what_all_parts_share(grid):
    more = study.sweep(DRIVE, SPEEDS, TORQUES, spectra_of=["span1.sin2"], n_functions=(3, 3, 2))
    both = study.combined({"2": grid, "3": more}, "series")
    assert both.rms.dims == ("series", "Omega", "Q_m", "coordinate")
    assert "span1.sin3" not in both.coordinate.values
    assert both.n_functions.values.tolist() == ["(2, 3, 2)", "(3, 3, 2)"]
    assert both.attrs["drive"] == DRIVE.name
    np.testing.assert_array_equal(both.rms.sel(series="2"), grid.rms)
