"""The words and options that the command understands.

Numbers are only read here; whether they can be used is decided by what uses them, so that one run
shows every mistake. Defaults are filled in by `beltsim.cli.operation`, which must know what was
given and what was not.

Depends on: nothing.
"""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Sequence
from typing import NoReturn

import beltsim

#: Folder for what `run` and `plot` write.
OUT = "beltsim-out"
#: Methods of the integrator; the settings of `beltsim.transient` decide.
METHODS = ("auto", "adams", "bdf", "taylor")

_STATUS = (
    "exit status: 0 done; 1 computed, but it failed or disagrees; 2 bad input; 130 interrupted"
)
_SIGMA_HELP = (
    "saturated law: a line instead of the jump at rest, up to this arm velocity in rad per unit of "
    "dimensionless time l sqrt(rho/P0), such as 1e-3; reports print it in deg/s (default: exact "
    "Coulomb friction)"
)
_RATIO = "over P0 r_t (reference tension times arm length)"
_OMEGA_HELP = "dimensionless firing frequency (reports print it beside the crank speed)"
_FILE_HELP = "drive file (TOML, or JSON with the same keys), or a result of `beltsim run`"


class _Parser(argparse.ArgumentParser):
    """An argument parser whose complaint is one line."""

    def error(self, message: str) -> NoReturn:
        sys.stderr.write(f"beltsim: {message} (see {self.prog} --help)\n")
        self.exit(2)


def parser() -> argparse.ArgumentParser:
    """The parser of the whole command."""
    top = _Parser(
        prog="beltsim",
        description="Serpentine belt drives whose tensioner arm rubs on its pivot.",
        epilog=_STATUS,
        allow_abbrev=False,
    )
    top.add_argument("--version", action="version", version=f"beltsim {beltsim.__version__}")
    verbs = top.add_subparsers(dest="verb", required=True, metavar="VERB", parser_class=_Parser)
    _modes(verbs)
    _run(verbs)
    _hb(verbs)
    _events(verbs)
    _sweep(verbs)
    _plot(verbs)
    _init(verbs)
    _verb(verbs, "schema", "print the JSON schema of drive files")
    _verb(verbs, "validate", "compare with closed forms, other solvers and printed numbers")
    return top


def read(words: Sequence[str]) -> argparse.Namespace:
    """What `words` ask for; a word that its verb does not know is answered by the verb.

    Raises
    ------
    SystemExit
        After the help that was asked for, or one line about a word that cannot be read.
    """
    top = parser()
    options, unknown = top.parse_known_args(words)
    if unknown:
        verb = next(
            action.choices[options.verb]
            for action in top._actions
            if isinstance(action, argparse._SubParsersAction)
        )
        known = [name for name in verb._option_string_actions if len(name) > 2]
        option = unknown[0].split("=")[0]
        near = [name for name in known if option.startswith("--") and name.startswith(option)]
        near = near or difflib.get_close_matches(option, known, 1, cutoff=0.75)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        verb.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
    return options


def _verb(verbs: argparse._SubParsersAction[_Parser], name: str, text: str) -> _Parser:
    sentence = text[0].upper() + text[1:] + "."
    made: _Parser = verbs.add_parser(
        name, help=text, description=sentence, epilog=_STATUS, allow_abbrev=False
    )
    return made


def _modes(verbs: argparse._SubParsersAction[_Parser]) -> None:
    text = "print steady tensions, hub loads, natural frequencies and the torque that locks the arm"
    verb = _verb(verbs, "modes", text)
    _add_operation(verb)
    verb.add_argument(
        "--count", type=_integer, metavar="N", default=12, help="frequencies to list (default: 12)"
    )


def _run(verbs: argparse._SubParsersAction[_Parser]) -> None:
    text = "integrate the drive in time, with every stop, reversal and release of the arm located"
    verb = _verb(verbs, "run", text)
    _add_operation(verb)
    solver = verb.add_argument_group("integration")
    solver.add_argument(
        "--periods", type=_number, metavar="X", help="length in forcing periods (default: 100)"
    )
    solver.add_argument(
        "--method",
        choices=METHODS,
        help="Adams or BDF formulas of CVODE, or Taylor series (default: auto: adams)",
    )
    solver.add_argument(
        "--rtol", type=_number, metavar="X", help="relative tolerance of a step (default: 1e-8)"
    )
    solver.add_argument(
        "--samples", type=_integer, metavar="N", help="samples per forcing period (default: 500)"
    )
    solver.add_argument(
        "--max-seconds", type=_number, metavar="X", help="give up after X s of computing"
    )
    _add_output(verb)
    verb.add_argument("--no-plot", action="store_true", help="draw no pictures")


def _hb(verbs: argparse._SubParsersAction[_Parser]) -> None:
    verb = _verb(verbs, "hb", "find the periodic response by harmonic balance")
    _add_operation(verb)
    method = verb.add_argument_group("method")
    method.add_argument(
        "-R",
        "--harmonics",
        type=_integer,
        metavar="N",
        default=15,
        help="highest harmonic of the forcing (default: 15); the time grows like N^3 with several "
        "excitation orders: seconds to a minute for 200, many minutes for 1000",
    )
    method.add_argument(
        "--sigma",
        type=_number,
        metavar="X",
        help=_SIGMA_HELP,
    )
    method.add_argument(
        "--pattern",
        metavar="RESULT",
        help="solve for the instants of the events in the last period of this stored run (default, "
        "where static friction exceeds the kinetic: of the exact orbit)",
    )
    method.add_argument(
        "--projection",
        choices=("auto", "exact", "sampled"),
        default="auto",
        help="harmonics of the torque: exact integrals, or sums over samples (default: auto: "
        "sampled with --sigma, as in the paper, else exact)",
    )
    verb.add_argument("--out", metavar="DIR", help=f"folder for the result (default: {OUT})")


def _events(verbs: argparse._SubParsersAction[_Parser]) -> None:
    text = "find the exact periodic motions over a range of friction torques"
    verb = _verb(verbs, "events", text)
    _add_operation(verb)
    study = verb.add_argument_group(f"range, Q_m {_RATIO} (default: to just above locking)")
    study.add_argument("--from", dest="lowest", type=_number, metavar="X", help="smallest Q_m")
    study.add_argument("--to", dest="highest", type=_number, metavar="X", help="largest Q_m")
    study.add_argument(
        "--count", type=_integer, metavar="N", default=40, help="torques (default: 40)"
    )
    study.add_argument(
        "--max-multiple",
        type=_integer,
        metavar="N",
        default=1,
        help="longest period to look for, in forcing periods, where Q_s > Q_m (default: 1)",
    )
    _add_output(verb)
    verb.add_argument("--no-plot", action="store_true", help="draw no picture")


def _sweep(verbs: argparse._SubParsersAction[_Parser]) -> None:
    text = "find the periodic motions over a range of speeds, for several friction torques"
    verb = _verb(verbs, "sweep", text)
    verb.add_argument("file", metavar="FILE", help=_FILE_HELP)
    text = "speeds (default: 60 from a fifth of the file's speed to one and a half times it)"
    speed = verb.add_argument_group(text).add_mutually_exclusive_group()
    shape = "LOW:HIGH:COUNT"
    speed.add_argument("--rpm", type=_range, metavar=shape, help="crank speeds, 1/min")
    speed.add_argument("--omega", "--Omega", type=_range, metavar=shape, help=_OMEGA_HELP)
    text = (
        "torques, such as 0,14.5,inf; inf locks the arm; the static keep the file's ratio to these "
        "(default: free, the file's, locked)"
    )
    torque = verb.add_argument_group(text).add_mutually_exclusive_group()
    torque.add_argument(
        "--friction-torque-N-m", type=_numbers, metavar="X,...", help="friction torques, N m"
    )
    torque.add_argument("--Q-m", type=_numbers, metavar="X,...", help=f"friction torques {_RATIO}")
    method = verb.add_argument_group("method (default: the exact event map)")
    method.add_argument(
        "-R",
        "--harmonics",
        type=_integer,
        metavar="N",
        help="use harmonic balance with N harmonics of the forcing",
    )
    method.add_argument("--sigma", type=_number, metavar="X", help=_SIGMA_HELP)
    _add_model(verb)
    _add_output(verb)
    verb.add_argument("--no-plot", action="store_true", help="draw no picture")
    verb.add_argument(
        "--strict", action="store_true", help="exit with status 1 when a point has no solution"
    )


def _plot(verbs: argparse._SubParsersAction[_Parser]) -> None:
    verb = _verb(verbs, "plot", "draw the layout of a drive file, or all pictures of a result")
    verb.add_argument("file", metavar="FILE", help=_FILE_HELP)
    _add_output(verb)


def _init(verbs: argparse._SubParsersAction[_Parser]) -> None:
    verb = _verb(verbs, "init", "write a commented drive file to start from")
    verb.add_argument(
        "path",
        metavar="PATH",
        nargs="?",
        default="drive.toml",
        help="file to write (default: drive.toml); - for standard output",
    )
    verb.add_argument("--force", action="store_true", help="replace a file that is there already")


def cross_check_parser() -> argparse.ArgumentParser:
    """The parser of `beltsim validate --drive FILE`."""
    verb = _Parser(
        prog="beltsim validate",
        description="Compute the steady motion of a drive by every solver, compare them, and put "
        "each motion back into the equations. Without --drive: compare beltsim with closed forms, "
        "other solvers and printed numbers (see `beltsim validate --help`).",
        epilog=_STATUS,
        allow_abbrev=False,
    )
    verb.add_argument("--drive", dest="file", metavar="FILE", required=True, help=_FILE_HELP)
    _add_point(verb)
    verb.add_argument(
        "--tolerance",
        type=_number,
        metavar="X",
        default=5e-3,
        help="relative error up to which harmonics are added to harmonic balance, by its own "
        "estimate (default: 0.005)",
    )
    return verb


def _add_operation(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("file", metavar="FILE", help=_FILE_HELP)
    _add_point(verb)


def _add_point(verb: argparse.ArgumentParser) -> None:
    point = verb.add_argument_group("operating point (default: that of the file)")
    speed = point.add_mutually_exclusive_group()
    speed.add_argument("--rpm", type=_number, metavar="X", help="crank speed, 1/min")
    speed.add_argument("--omega", "--Omega", type=_number, metavar="X", help=_OMEGA_HELP)
    text = "friction of the arm (default: that of the file; a new kinetic value is also the static)"
    arm = verb.add_argument_group(text)
    for option, unit in (("", "N m"), ("static-", "N m")):
        name = "static" if option else "kinetic"
        either = arm.add_mutually_exclusive_group()
        either.add_argument(
            f"--{option}friction-torque-N-m",
            type=_number,
            metavar="X",
            help=f"{name} friction torque, {unit}",
        )
        either.add_argument(
            f"--Q-{name[0].replace('k', 'm')}",
            type=_number,
            metavar="X",
            help=f"{name} friction torque {_RATIO}",
        )
    _add_model(verb)


def _add_model(verb: argparse.ArgumentParser) -> None:
    model = verb.add_argument_group("model")
    model.add_argument(
        "--functions",
        type=_counts,
        metavar="N",
        help="sine functions per span, one number or one per span as 4,5,5 (default: 16)",
    )
    model.add_argument(
        "--no-residual-flexibility",
        action="store_true",
        default=None,
        help="leave out the static share of the sines beyond these",
    )


def _add_output(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("--out", metavar="DIR", help=f"folder for the files (default: {OUT})")
    verb.add_argument(
        "--format",
        choices=("png", "pdf", "svg"),
        default="png",
        help="of the pictures (default: png)",
    )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no number") from None


def _integer(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no integer") from None


def _numbers(text: str) -> list[float]:
    return [_number(word) for word in text.split(",")]


def _range(text: str) -> tuple[float, float, int]:
    words = text.split(":")
    if len(words) != 3:
        raise argparse.ArgumentTypeError(f"{text!r} is no range such as 600:6000:50")
    return _number(words[0]), _number(words[1]), _integer(words[2])


def _counts(text: str) -> int | list[int]:
    try:
        numbers = [int(word) for word in text.split(",")]
    except ValueError:
        message = f"{text!r} is neither an integer nor a list such as 4,5,5"
        raise argparse.ArgumentTypeError(message) from None
    return numbers if "," in text else numbers[0]
