"""Each of the paper's figures comes from one call, and its picture shows it."""

from __future__ import annotations

import numpy as np
import pytest

from validation.zhu_parker_2008.figures import FIGURES
from validation.zhu_parker_2008.figures.__main__ import main
from validation.zhu_parker_2008.figures.pictures import DRAWN, pictures

#: A coarse grid of the horizontal axis where it is not Omega.
TORQUES = {"fig06": [0.5, 3.5], "fig08": [0.5, 3.5], "fig09": [3.5]}


@pytest.mark.parametrize("name", FIGURES)
def test_figure_is_complete(name):
    data = FIGURES[name](TORQUES.get(name, [4.2]))
    first = data[next(iter(data.data_vars))]
    assert first.notnull().any()
    assert "failure" in data
    if name != "fig10":
        exact = data.sel(computation=DRAWN[:2])
        assert (exact.failure == "").all()
        assert exact[first.name].notnull().all()
    drawn = pictures(name, data)
    assert name in next(iter(drawn))
    assert all(figure.axes for figure in drawn.values())


def test_the_four_computations_agree_away_from_locking():
    """At Q_m = 0.5 and 6.3 the arm slips all the time: only the sine series makes a difference."""
    energy = FIGURES["fig08"]([0.5]).dissipated_energy.sel(Omega=6.3).values.ravel()
    exact, converged, paper, both = energy
    np.testing.assert_allclose([paper, both], [exact, converged], rtol=2e-3)
    assert abs(converged / exact - 1.0) < 0.05


def test_unknown_figures_are_refused(capsys, tmp_path):
    assert main(["fig99", "--out", str(tmp_path)]) == 2
    assert "fig03" in capsys.readouterr().err


def test_command_writes_dataset_and_picture(tmp_path):
    assert main(["fig09", "--out", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"fig09.nc", "fig09.png"}
