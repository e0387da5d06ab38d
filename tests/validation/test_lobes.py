"""The stored data of docs/lobes.md: cells computed anew come out the same."""

from __future__ import annotations

import numpy as np
import pytest

from validation.zhu_parker_2008.fig08_lobes import data, draw

#: Energies are compared closely; other machines round differently, and a run in time by its rtol.
CLOSE = 1e-6
#: The set-valued method accepts a gap of 1e-5, and an energy may be off by the root of that.
WITHIN_GAP = 3e-3


def same(found, stored, close=CLOSE) -> None:
    for name in ("dissipated_energy", "velocity_reversals", "reversals_of_series"):
        if name in stored:
            np.testing.assert_allclose(
                found[name].values.ravel(), stored[name].values.ravel(), rtol=close, atol=CLOSE
            )


def test_every_part_is_stored():
    assert {path.stem for path in data.DATA.glob("*.nc")} == set(data.PARTS)
    assert sum(path.stat().st_size for path in data.DATA.glob("*.nc")) < 2e6


@pytest.mark.parametrize("name", ["event map", "CVODE"])
def test_cells_in_time(name):
    stored = data.load("time_domain")
    for sigma in (0.0, 1e-5):
        found = data.sweep([data.OMEGA], [3.5, 8.5], data.time_method(name, sigma))
        same(found, stored.sel(solver=name, sigma=sigma, Q_m=[3.5, 8.5]))


@pytest.mark.parametrize(("R", "sigma"), [(5, 1e-3), (9, 1e-4), (13, 0.0), (101, 0.0)])
def test_cells_of_series(R, sigma):
    stored = data.load("series").sel(R=R, sigma=sigma, Q_m=[1.0, 3.5])
    found = data.sweep([data.OMEGA], [1.0, 3.5], data.series_method(R, sigma))
    same(found, stored, WITHIN_GAP if sigma == 0.0 else CLOSE)


def test_cells_of_the_exact_curve_and_of_the_maps():
    stored = data.load("exact").isel(series=0).sel(Omega=[5.7, 6.3], Q_m=[2.0, 6.1])
    same(data.sweep([5.7, 6.3], [2.0, 6.1], data.time_method("event map", 0.0)), stored)
    maps = data.load("maps").sel(Omega=[0.4, 2.8], share=[0.3, 0.7])
    for case in ("damping 0.5 %", "Q_s = 1.5 Q_m"):
        options, method = data.MAPS[case]
        found = data.sweep([0.4, 2.8], [0.3, 0.7], method, relative=True, **options)
        stored = maps.sel(case=case)
        same(found, stored)
        np.testing.assert_array_equal(found.phases_per_period, stored.phases_per_period)


@pytest.mark.parametrize("name", draw.PICTURES)
def test_pictures_can_be_drawn_again(name):
    figure = draw.PICTURES[name]()
    assert figure.axes
    assert (draw.FIGURES / f"{name}.png").stat().st_size < 250_000
