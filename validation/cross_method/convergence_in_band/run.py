"""Orbits of the saturated law in ever narrower bands, beside the orbit of Coulomb's law."""

import numpy as np

from beltsim import SaturatedCoulomb, event_map, transient
from validation.cross_method.orders import along_line, order
from validation.reference import printed
from validation.row import Row
from validation.zhu_parker_2008.paper import problem

Q_M = 3.5
BANDS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
SETTINGS = event_map.Settings(harmonics=200)


def compute() -> list[Row]:
    expected = printed(__file__)
    at = problem(6.3, Q_m=Q_M)
    exact = event_map.periodic(at, SETTINGS)
    orbits = [
        event_map.periodic(at.with_friction(SaturatedCoulomb(Q_M, s)), SETTINGS) for s in BANDS
    ]
    motion = [_gap(orbit, exact) for orbit in orbits]
    energy = [abs(orbit.dissipated_energy / exact.dissipated_energy - 1.0) for orbit in orbits]
    peak = np.abs(exact.q_dot[:, at.joint]).max()
    rows = []
    for name, errors in (("motion", motion), ("energy", energy)):
        rows += [
            Row(f"order, {name}", order(BANDS, errors), expected["order"]),
            Row(
                f"log10 of the error of the {name}",
                np.log10(errors),
                along_line(BANDS, errors, expected["order"]),
                np.log10(BANDS),
                "log10 of the band sigma (theta_t per unit of time)",
                "log10 of the relative error",
            ),
        ]
    largest = max(error / sigma * peak for error, sigma in zip(motion, BANDS, strict=True))
    rows.append(Row("error of the motion over sigma/v, largest", largest, expected["bound"]))
    return [
        *rows,
        Row("C core beside the map, sigma = 1e-3", _by_core(orbits[1]), expected["zero"]),
    ]


def _gap(orbit: object, exact: object) -> float:
    """Rms of the difference of the arm's motion, mean left out, over the rms of the motion."""
    joint = exact.problem.joint
    ours, theirs = (each.coefficients[1:, joint] for each in (orbit, exact))
    return float(np.linalg.norm(ours - theirs) / np.linalg.norm(theirs))


def _by_core(orbit: object) -> float:
    """Change of the state after a period of the C core that starts on the map's orbit."""
    start = orbit.initial_state
    run = transient.integrate(orbit.problem, 1.0, start)
    weight = np.repeat([1.0, 1.0 / 6.3], orbit.problem.n)
    return float(np.abs((run.final_state - start) * weight).max() / np.abs(start * weight).max())
