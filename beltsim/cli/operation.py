"""From a file and options to the friction problem of one operating point.

What is given on the command line goes before what a stored run was started with, and that before
the drive file.

Depends on: drive, model, metrics, friction, errors; cli.source.
"""

from __future__ import annotations

import argparse
from typing import Any

from beltsim.cli.mistakes import Mistakes
from beltsim.cli.source import Source
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.friction import Coulomb
from beltsim.metrics import Survey, survey
from beltsim.model import assemble
from beltsim.model.scaling import scale
from beltsim.problem import FrictionProblem

#: Options of which giving one takes back the others of a stored run.
_GROUPS = (
    ("rpm", "omega"),
    ("friction_torque_N_m", "Q_m", "static_friction_torque_N_m", "Q_s"),
)
#: Harmonics that the command takes at most.
MOST_HARMONICS = 1000
#: Options that decide what is computed; a result file stores them.
NAMES = (
    *(name for group in _GROUPS for name in group),
    *("functions", "no_residual_flexibility", "periods", "method", "rtol", "samples"),
    "max_seconds",
)


def given(options: argparse.Namespace) -> dict[str, Any]:
    """The arguments on the command line that decide what is computed."""
    found = {name: getattr(options, name, None) for name in NAMES}
    return {name: value for name, value in found.items() if value is not None}


def merged(options: argparse.Namespace, stored: dict[str, Any]) -> dict[str, Any]:
    """The arguments that count: those given, and of `stored` what they do not replace."""
    fresh = given(options)
    replaced = {name for group in _GROUPS if fresh.keys() & set(group) for name in group}
    kept = {name: value for name, value in stored.items() if name in NAMES and name not in replaced}
    return kept | fresh


def rpm_of(source: Source) -> float:
    """Crank speed of a drive file, or of the run stored in a result."""
    drive, stored = source.drive, source.arguments
    if "rpm" in stored:
        return float(stored["rpm"])
    return drive.rpm(stored.get("omega", drive.Omega))


def friction_given(source: Source, arguments: dict[str, Any]) -> Coulomb | None:
    """The law that the arguments give, in units of P0 r_t; None for the drive's own.

    A new kinetic torque replaces the drive's law altogether, its static torque too.

    Raises
    ------
    InvalidProblemError
        On torques that cannot be, or a drive without a tensioner.
    """
    law = {name: arguments[name] for name in _GROUPS[1] if name in arguments}
    if not law:
        return None
    if source.drive.tensioner is None:
        option, value = next(iter(law.items()))
        name = f"--{option.replace('_', '-')}"
        allowed = "left out: this drive has no tensioner"
        raise InvalidProblemError(Mistake(name, value, allowed))
    unit = scale(source.drive).torque_N_m
    kinetic, static = law.get("Q_m"), law.get("Q_s")
    if "friction_torque_N_m" in law:
        kinetic = law["friction_torque_N_m"] / unit
    if "static_friction_torque_N_m" in law:
        static = law["static_friction_torque_N_m"] / unit
    if kinetic is None:
        kinetic = source.drive.tensioner.friction_torque_N_m / unit
    try:
        return Coulomb(kinetic, static)
    except InvalidProblemError as error:
        raise InvalidProblemError([_in_newton_metres(one, law) for one in error.mistakes]) from None


def _in_newton_metres(mistake: Mistake, law: dict[str, Any]) -> Mistake:
    """A mistake of the law with the option and the value that were given, where they were SI."""
    options = {
        "friction.Q_m": "friction_torque_N_m",
        "friction.Q_s": "static_friction_torque_N_m",
    }
    given_as = options[mistake.field]
    if given_as not in law:
        return mistake
    allowed = "a finite number >= 0"
    if mistake.field == "friction.Q_s":
        allowed = "a finite number, at least the kinetic friction torque"
    return Mistake(f"--{given_as.replace('_', '-')}", law[given_as], allowed)


def examined(
    source: Source, arguments: dict[str, Any], law: Coulomb | None, n_modes: int = 12
) -> tuple[FrictionProblem, Survey]:
    """The friction problem of the drive under `arguments`, and what is known without integrating.

    Raises
    ------
    InvalidProblemError, SteadyStateError
        On arguments that cannot be used, or without a usable steady state.
    """
    if n_modes < 1:
        raise InvalidProblemError(Mistake("--count", n_modes, "an integer >= 1"))
    point: dict[str, Any] = {
        "Omega": arguments.get("omega"),
        "rpm": arguments.get("rpm"),
        "friction": law,
        "n_functions": arguments.get("functions", 16),
        "residual_flexibility": not arguments.get("no_residual_flexibility", False),
    }
    problem = assemble(source.drive, **point)
    return problem, survey(source.drive, **point, n_modes=n_modes)


def require_harmonics(count: int | None) -> None:
    """Refuse no harmonic at all, and a number that fills the memory before it fails."""
    if count is not None and not 1 <= count <= MOST_HARMONICS:
        allowed = f"an integer from 1 to {MOST_HARMONICS}"
        raise InvalidProblemError(Mistake("--harmonics", count, allowed))


def require_periods(arguments: dict[str, Any], mistakes: Mistakes) -> float:
    """Length of the run in periods; a mistake is gathered."""
    periods = arguments.get("periods", 100.0)
    with mistakes.gathered():
        if not 0.0 < periods <= 1e12:
            allowed = "a finite number > 0, at most 1e12"
            raise InvalidProblemError(Mistake("--periods", periods, allowed))
    return float(periods)
