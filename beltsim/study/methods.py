"""The solvers as values that a study can be given: which one, and with which friction law.

With `sigma` the law is the saturated one of that band, without it exact Coulomb friction.

Depends on: friction, problem, response, errors, the solvers; study.balance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from beltsim import event_map, harmonic_balance, transient
from beltsim.checks import FloatArray
from beltsim.errors import BeltsimError
from beltsim.friction import Coulomb, FrictionLaw, SaturatedCoulomb
from beltsim.metrics.rms import rms as rms_of
from beltsim.problem import FrictionProblem
from beltsim.response import Response
from beltsim.study.balance import balance

Found = list[Response | BeltsimError]


def _law(Q_m: float, sigma: float | None, static_ratio: float = 1.0) -> FrictionLaw:
    if sigma is None:
        return Coulomb(Q_m, Q_m * static_ratio)
    return SaturatedCoulomb(Q_m, sigma)


@dataclass(frozen=True)
class EventMap:
    """Exact periodic orbits.

    Parameters
    ----------
    sigma : float, optional
        Band of the saturated law.
    static_ratio : float
        Q_s / Q_m of the exact law.
    max_multiple : int
        Longest period to look for, in forcing periods; more than 1 only helps when Q_s > Q_m.
    harmonics, samples_per_period : int
        What each orbit carries: harmonics serve spectra and extremes of tension.
    figures_only : bool
        Leave out what needs the motion itself (tensions, phases, spectra): quicker, for maps of
        rms, losses, sticking, stops and reversals.

    Examples
    --------
    >>> EventMap(static_ratio=1.5).law(2.0)
    Coulomb(Q_m=2.0, Q_s=3.0)
    """

    sigma: float | None = None
    static_ratio: float = 1.0
    max_multiple: int = 1
    harmonics: int = 40
    samples_per_period: int = 1
    figures_only: bool = False

    def law(self, Q_m: float) -> FrictionLaw:
        """The friction law of torque `Q_m`."""
        return _law(Q_m, self.sigma, self.static_ratio)

    def solve(self, problems: Sequence[FrictionProblem]) -> Found:
        """One orbit, or why there is none, for each problem."""
        return event_map.solve_many(problems, self._settings, workers=1)

    def survey(self, problems: Sequence[FrictionProblem]) -> event_map.Survey:
        """The figures of these orbits alone."""
        return event_map.survey(problems, self._settings, workers=1)

    @property
    def _settings(self) -> event_map.Settings:
        return event_map.Settings(
            samples_per_period=self.samples_per_period,
            harmonics=self.harmonics,
            max_multiple=self.max_multiple,
        )

    def rms(self, response: Response) -> FloatArray:
        """Root mean squares (n,) of the coordinates, in closed form."""
        return event_map.rms(response)


@dataclass(frozen=True)
class HarmonicBalance:
    """Truncated Fourier series: set-valued without `sigma`, the paper's method with it.

    With a `static_ratio` above 1 each series takes its pattern of events from the exact orbit.

    Parameters
    ----------
    R : int
        Highest harmonic.
    sigma : float, optional
        Band of the saturated law.
    samples : int, optional
        Instants per period of the paper's method; default as in `harmonic_balance.Settings`.
    sigma_ladder : bool
        Whether the paper's method comes down to sigma from a wide band.
    samples_per_period : int
        Samples each response carries.
    static_ratio : float
        Q_s / Q_m of the exact law.

    Examples
    --------
    >>> HarmonicBalance(R=9, sigma=1e-4).law(0.5)
    SaturatedCoulomb(Q_m=0.5, sigma=0.0001)
    """

    R: int = 15
    sigma: float | None = None
    samples: int | None = None
    sigma_ladder: bool = True
    samples_per_period: int = 200
    static_ratio: float = 1.0

    def law(self, Q_m: float) -> FrictionLaw:
        """The friction law of torque `Q_m`."""
        return _law(Q_m, self.sigma, self.static_ratio)

    def solve(self, problems: Sequence[FrictionProblem]) -> Found:
        """One series, or why there is none, for each problem."""
        settings = harmonic_balance.Settings(
            samples=self.samples,
            sigma_ladder=self.sigma_ladder,
            estimate=False,
            samples_per_period=self.samples_per_period,
        )
        if self.static_ratio == 1.0:
            return harmonic_balance.solve_many(problems, settings, workers=1, R=self.R)
        return [_balanced(problem, self.R, settings) for problem in problems]

    def rms(self, response: Response) -> FloatArray:
        """Root mean squares (n,) of the coordinates, from the series."""
        return rms_of(response)


@dataclass(frozen=True)
class Transient:
    """Runs in time with CVODE, started from rest; the last period counts.

    Parameters
    ----------
    periods : float
        Length of each run in forcing periods.
    sigma : float, optional
        Band of the saturated law.
    static_ratio : float
        Q_s / Q_m of the exact law.
    rtol : float
    samples_per_period : int

    Examples
    --------
    >>> Transient(periods=50).law(0.5)
    Coulomb(Q_m=0.5, Q_s=0.5)
    """

    periods: float = 100.0
    sigma: float | None = None
    static_ratio: float = 1.0
    rtol: float = 1e-8
    samples_per_period: int = 500

    def law(self, Q_m: float) -> FrictionLaw:
        """The friction law of torque `Q_m`."""
        return _law(Q_m, self.sigma, self.static_ratio)

    def solve(self, problems: Sequence[FrictionProblem]) -> Found:
        """One run, or why it stopped, for each problem."""
        settings = transient.Settings(rtol=self.rtol, samples_per_period=self.samples_per_period)
        return transient.solve_many(problems, settings, workers=1, periods=self.periods)

    def rms(self, response: Response) -> FloatArray:
        """Root mean squares (n,) of the coordinates, from the samples."""
        return rms_of(response)


def _balanced(
    problem: FrictionProblem, R: int, settings: harmonic_balance.Settings
) -> Response | BeltsimError:
    try:
        return balance(problem, R, settings)
    except BeltsimError as error:
        return error


Method = EventMap | HarmonicBalance | Transient
