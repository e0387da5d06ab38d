"""`beltsim sweep`: periodic responses over crank speed, for several friction torques.

Writes one dataset and one picture, and prints for each torque where the arm, the tensions and the
friction loss are largest.

Depends on: study, io, model; the other modules of cli.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from beltsim import study
from beltsim.checks import FloatArray
from beltsim.cli.arguments import OUT
from beltsim.cli.mistakes import Mistakes
from beltsim.cli.operation import require_harmonics, rpm_of
from beltsim.cli.progress import progress
from beltsim.cli.source import Source, read_source
from beltsim.cli.steady import warning_lines
from beltsim.cli.text import complain, say, short, table
from beltsim.errors import InvalidProblemError, Mistake, ResultFileError
from beltsim.io import require_writable, save_dataset
from beltsim.model.scaling import scale

#: Failures that are listed; the rest is counted.
LISTED = 5


class _Job(NamedTuple):
    """A sweep with everything that it needs, checked."""

    source: Source
    speeds: FloatArray
    torques: FloatArray
    method: study.Method
    model: dict[str, Any]
    stem: Path


def run(options: argparse.Namespace) -> int:
    """Solve, write and print; the exit status."""
    job = _prepared(options)
    with progress("sweep") as shown:
        found = study.sweep(
            job.source.drive, job.speeds, job.torques, job.method, progress=shown, **job.model
        )
    inputs = {"drive": job.source.text, "suffix": job.source.suffix, "arguments": {}}
    found.attrs["inputs"] = json.dumps(inputs)
    written, trouble = _write(job, found, None if options.no_plot else options.format)
    say(job.source.drive.name or job.stem.name, f"  {_extent(found)}", *_law_lines(job), "")
    say(*table(_TITLES, [_row(found.isel(Q_m=i)) for i in range(found.sizes["Q_m"])]))
    say(*warning_lines(_slack(found)))
    if written:
        say("", "Written", *(f"  {path}" for path in written))
    failures = _failures(found)
    for text in failures[:LISTED]:
        complain(text)
    if len(failures) > LISTED:
        complain(f"{len(failures) - LISTED} more failures; the dataset says why")
    complain(trouble)
    return 1 if trouble or (options.strict and failures) else 0


def _failures(found: Any) -> list[str]:
    """Why points have no solution; torques that share speed and reason in one sentence."""
    said = []
    for speed, reasons in zip(found.crank_speed.values, found.failure.values, strict=True):
        for reason in dict.fromkeys(reasons[reasons != ""].tolist()):
            torques = ", ".join(f"{Q:.4g}" for Q in found.Q_m.values[reasons == reason])
            said.append(f"{speed:.0f} rpm, Q_m = {torques}: {reason}")
    return said


_TITLES = ("Q_m", "N m", "arm deg", "at rpm", "dynamic N", "at rpm", "loss W", "at rpm", "failed")


def _row(one: Any) -> list[str]:
    """Largest rms of the arm, dynamic tension and friction power of one torque, and where."""
    figures = _figures(one)
    cells = [f"{one.Q_m.item():.4g}", f"{one.Q_m.item() * one.Q_m.attrs['si_scale']:.4g}"]
    for values in figures.values():
        good = np.isfinite(values)
        if not good.any():
            cells += ["-", "-"]
            continue
        top = int(np.argmax(np.where(good, values, -np.inf)))
        largest = float(values[top])
        cells += [short(largest), f"{one.crank_speed[top].item():.0f}" if largest else "-"]
    return [*cells, str(int((one.failure.values != "").sum()))]


def _figures(found: Any) -> dict[str, Any]:
    """What is printed and drawn, in SI, by the label of its axis."""
    energy, speed = found.dissipated_energy, found.Omega
    period_s = 2.0 * np.pi / (speed * speed.attrs["si_scale"])
    arm = found.coordinate.values[-1]  # the arm comes last
    tension = found.peak_dynamic_tension
    return {
        "rms of the arm (deg)": np.degrees(found.rms.sel(coordinate=arm)),
        "largest dynamic tension (N)": tension.max("span") * tension.attrs["si_scale"],
        "friction loss (W)": energy * energy.attrs["si_scale"] / period_s,
    }


def _by_si(data: Any) -> Any:
    """`data` over crank speed in rpm and friction torque in N m."""
    torque = data.Q_m * data.Q_m.attrs["si_scale"]
    named = data.assign_coords(friction_torque=torque)
    return named.swap_dims(Omega="crank_speed", Q_m="friction_torque")


def _slack(found: Any) -> tuple[str, ...]:
    """Which spans push, where the model is no belt's."""
    tension, said = found.lowest_tension, []
    for k in range(found.sizes["span"]):
        values = tension.isel(span=k)
        slack = int((values < 0.0).sum())
        if slack:
            far = float(values.min()) * tension.attrs["si_scale"]
            count = f"{slack} of {int(values.notnull().sum())} points"
            said.append(
                f"tension of span {k + 1} falls below 0 N at {count}, as far as {far:.6g} N"
            )
    return tuple(said)


def _extent(found: Any) -> str:
    rpm = found.crank_speed.values
    said = "rms of the arm, largest tension over the steady one"
    return f"{len(rpm)} speeds, {rpm.min():.0f} to {rpm.max():.0f} rpm ({said})"


def _law_lines(job: _Job) -> list[str]:
    """Static friction above the kinetic, or the band of the saturated law in SI."""
    ratio, sigma = getattr(job.method, "static_ratio", 1.0), getattr(job.method, "sigma", None)
    if sigma is None:
        return (
            []
            if ratio == 1.0
            else [f"  static friction {ratio:.4g} times the kinetic, as in the file"]
        )
    speed = np.degrees(sigma / scale(job.source.drive).time_s)
    return [f"  saturated law: full friction from {short(speed)} deg/s (sigma = {sigma:g})"]


def _prepared(options: argparse.Namespace) -> _Job:
    """The job, or every mistake in its input at once."""
    out, mistakes = Path(options.out or OUT), Mistakes()
    source = read_source(options.file)
    drive = source.drive
    speeds, torques = np.zeros(0), np.zeros(0)
    with mistakes.gathered():
        if drive.tensioner is None:
            raise InvalidProblemError(f"{options.file}: this drive has no tensioner, so no sweep")
    with mistakes.gathered():
        low, high, count = options.rpm or options.omega or _default_range(source)
        option = "--rpm" if options.rpm else "--omega"
        if not (0.0 < low < high < np.inf and 2 <= count <= 100_000):
            allowed = "LOW:HIGH:COUNT with 0 < LOW < HIGH and 2 to 100000 speeds"
            raise InvalidProblemError(Mistake(option, f"{low:g}:{high:g}:{count}", allowed))
        speeds = np.linspace(low, high, count)
        if options.rpm:
            speeds = np.array([drive.omega(value) for value in speeds.tolist()])
    with mistakes.gathered():
        torques = _torques(options, drive)
    with mistakes.gathered():
        require_harmonics(options.harmonics)
    with mistakes.gathered():
        require_writable(out)
    with mistakes.gathered():
        method = _method(options, drive)
    mistakes.raise_any()
    model = {
        "n_functions": options.functions or 16,
        "residual_flexibility": not options.no_residual_flexibility,
    }
    return _Job(source, speeds, torques, method, model, out / Path(options.file).stem)


def _default_range(source: Source) -> tuple[float, float, int]:
    """Firing frequencies about the file's own: lowest, highest, how many."""
    own = source.drive.omega(rpm_of(source))
    return 0.2 * own, 1.5 * own, 60


def _method(options: argparse.Namespace, drive: Any) -> study.Method:
    """The solver asked for, with the file's ratio of static to kinetic friction."""
    arm, ratio = drive.tensioner, 1.0
    if arm is not None and arm.static_friction_torque_N_m and arm.friction_torque_N_m:
        ratio = arm.static_friction_torque_N_m / arm.friction_torque_N_m
    if ratio > 1.0 and options.sigma is not None:
        text = "static friction above the kinetic: the saturated law has none; leave out --sigma"
        raise InvalidProblemError(f"{options.file}: {text}")
    if options.harmonics is not None:
        found: study.Method = study.HarmonicBalance(
            options.harmonics, sigma=options.sigma, static_ratio=ratio
        )
    else:
        longest = 3 if ratio > 1.0 else 1
        found = study.EventMap(options.sigma, static_ratio=ratio, max_multiple=longest)
    found.law(1.0)  # refuses a band that cannot be
    return found


def _torques(options: argparse.Namespace, drive: Any) -> FloatArray:
    """Torques over P0 r_t: those given, or free, the drive's own, and locked."""
    unit = scale(drive).torque_N_m if drive.tensioner is not None else 1.0
    if options.Q_m is not None:
        name, values = "--Q-m", np.array(options.Q_m)
    elif options.friction_torque_N_m is not None:
        name, values = "--friction-torque-N-m", np.array(options.friction_torque_N_m) / unit
    else:
        own = drive.tensioner.friction_torque_N_m if drive.tensioner is not None else 0.0
        return np.unique([0.0, own / unit, np.inf])
    if not (values >= 0.0).all():
        raise InvalidProblemError(Mistake(name, values.tolist(), "numbers >= 0, or inf"))
    return np.unique(values)


def _write(job: _Job, found: Any, picture: str | None) -> tuple[list[Path], str]:
    """The files written, and what went wrong with the first that could not be."""
    written: list[Path] = []
    try:
        job.stem.parent.mkdir(parents=True, exist_ok=True)
        path = job.stem.with_name(f"{job.stem.name}-sweep.nc")
        written.append(save_dataset(found, path))
        if picture is not None:
            from beltsim import plots  # loads matplotlib

            title = job.source.drive.name or job.stem.name
            doubtful = (found.largest_multiplier > 1.0 + 1e-6) | (found.coexisting > 0.0)
            panels = _figures(found)
            panels = {name: _by_si(data) for name, data in panels.items()}
            dimensions = ("crank_speed", "friction_torque")
            figure = plots.curves(panels, *dimensions, title=title, doubtful=_by_si(doubtful))
            written.append(plots.save_figure(figure, path.with_suffix(f".{picture}")))
    except (OSError, ResultFileError) as error:
        return written, str(error)
    return written, ""
