"""Pictures of studies: the curves are the data, holes are visible, units are named."""

import numpy as np
import pytest
import xarray

import beltsim
from beltsim import plots, study
from beltsim.errors import InvalidProblemError

DRIVE = beltsim.presets.zhu_parker_2008()


@pytest.fixture(scope="module")
def grid():
    return study.sweep(
        DRIVE, [2.8, 6.3], [0.5, 3.5, np.inf], n_functions=3, spectra_of=["span1.sin3"]
    )


def words(figure):
    from matplotlib.text import Text

    return "\n".join(text.get_text() for text in figure.findobj(Text))


def test_curves_are_the_data(grid):
    arm = grid.rms.sel(coordinate="theta_t")
    figure = plots.curves({"arm (rad)": arm}, "Omega", "Q_m", title="Arm")
    lines = figure.axes[0].get_lines()
    for line, Q_m in zip(lines, grid.Q_m, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), arm.sel(Q_m=Q_m))
    said = words(figure)
    assert "locked arm" in said
    assert "$Q_m$ = 0.5" in said
    assert "arm (rad)" in said
    figure.canvas.draw()
    assert "crank speed (rpm)" in words(figure)


def test_every_point_of_a_curve_shows_also_failed_and_doubtful_ones():
    """One panel: a line with a gap, so that its first point stands alone; a ring, a cross."""
    data = xarray.DataArray([1.0, np.nan, 2.0, 3.0], {"Omega": [1.0, 2.0, 3.0, 4.0]}, ("Omega",))
    figure = plots.curves({"a": data}, "Omega", doubtful=data > 2.5)
    line, alone, cross, ring = figure.axes[0].get_lines()
    assert line.get_markersize() > 0.0
    assert [one.get_xdata().tolist() for one in (alone, cross, ring)] == [[1.0], [2.0], [4.0]]
    assert "no solution" in words(figure)
    assert "unstable" in words(figure)
    plain = plots.curves({"a": data[2:]}, "Omega")
    assert len(plain.axes[0].get_lines()) == 1
    assert "no solution" not in words(plain)


def test_curves_refuse_what_they_cannot_tell_apart(grid):
    with pytest.raises(InvalidProblemError, match="coordinate"):
        plots.curves({"rms": grid.rms}, "Omega", "Q_m")
    with pytest.raises(InvalidProblemError, match="no panels"):
        plots.curves({}, "Omega")


def test_holes_of_a_map_are_crossed(tmp_path):
    orders = [5, 9, 101]
    values = np.array([[0.0, 1.0], [np.nan, 2.0], [40.0, 3.0]])
    data = xarray.DataArray(values, {"R": orders, "Q_m": [1.0, 2.0]}, ("R", "Q_m"))
    figure = plots.grid_map({"a": data}, "Q_m", "R", "nu", y_label="R")
    (crosses,) = figure.axes[0].get_lines()
    assert len(crosses.get_xdata()) == 1
    ticks = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert ticks == ["5", "9", "101"]
    plots.save_figure(figure, tmp_path / "map.png")


def test_waterfall_has_a_stem_for_each_harmonic_that_shows(grid):
    spectrum = grid.amplitude.sel(Q_m=0.5, signal="span1.sin3")
    figure = plots.waterfall({"": spectrum}, "$a_3$ (span lengths)")
    (stems,) = figure.axes[0].collections
    assert len(stems._segments3d) == int((spectrum > 1e-4 * spectrum.max()).sum())
    with pytest.raises(InvalidProblemError, match="harmonic"):
        plots.waterfall({"": grid.stick_fraction}, "a")


def test_histories_show_each_method(tmp_path):
    parts = {
        name: study.histories(DRIVE, 6.3, [3.5, 6.1], method, samples=50, n_functions=3)
        for name, method in {"exact": study.EventMap(), "R = 9": study.HarmonicBalance(9)}.items()
    }
    figure = plots.arm_histories(study.combined(parts, "solver"))
    curves = [line for line in figure.axes[0].get_lines() if len(line.get_xdata()) == 51]
    assert len(curves) == 2
    np.testing.assert_array_equal(curves[1].get_ydata(), parts["R = 9"].velocity[0])
    plots.save_figure(figure, tmp_path / "arm.png")


def test_curves_say_how_to_tell_a_dimension_apart(grid):
    with pytest.raises(InvalidProblemError, match=r"tell Q_m apart with lines= or styles="):
        plots.curves({"loss": grid.dissipated_energy}, "Omega")
    with pytest.raises(InvalidProblemError, match=r"panels = 'DataArray': must be a mapping"):
        plots.curves(grid.dissipated_energy, "Omega", "Q_m")
