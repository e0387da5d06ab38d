"""The set-valued law through scikit-sundae: event-driven Python around another build of CVODE.

A peer of beltsim's core: other SUNDIALS version, other binding, its own transition rule, the state
in plain physical coordinates. A new CVODE object is made for every segment, since a second
`solve` of the same object still reports the events of the first. A CVODE that returns from a root
is restarted there with the velocity of the joint set to exactly zero.

No import from beltsim.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

SLIP = {1: "slip+", -1: "slip-"}
#: More events than this in one run mean chatter, not motion.
MAX_EVENTS = 10_000


@dataclass(frozen=True)
class PeerRun:
    """Event times and kinds, and the state at the end."""

    t: np.ndarray
    kind: list[str]
    final_state: np.ndarray


class _Peer:
    def __init__(self, problem: Any, rtol: float, atol: float) -> None:
        self.n, self.j = len(problem.M), problem.joint
        self.problem, self.rtol, self.atol = problem, rtol, atol
        self.keep = np.delete(np.arange(self.n), self.j)
        self.inverse = np.linalg.inv(problem.M)
        cut = np.ix_(self.keep, self.keep)
        self.stuck_inverse = np.linalg.inv(problem.M[cut])
        self.B = problem.C + problem.G
        # roots are looked for at step ends only, and a stuck system at rest allows any step
        fastest = problem.forcing.Omega * max(1, len(problem.forcing.cos) - 1)
        self.max_step = 2.0 * np.pi / fastest / 50.0
        self.orders = problem.forcing.Omega * np.arange(len(problem.forcing.cos))

    def load(self, t: float, y: np.ndarray) -> np.ndarray:
        """Load f - (C + G) q' - K q, all coordinates."""
        forcing = self.problem.forcing
        f = np.cos(self.orders * t) @ forcing.cos + np.sin(self.orders * t) @ forcing.sin
        loaded: np.ndarray = f - self.B @ y[self.n :] - self.problem.K @ y[: self.n]
        return loaded

    def reaction(self, t: float, y: np.ndarray) -> float:
        """Torque that holds the joint: what is left of its row when it does not accelerate."""
        load = self.load(t, y)
        accelerations = self.stuck_inverse @ load[self.keep]
        return float(load[self.j] - self.problem.M[self.j, self.keep] @ accelerations)

    def rates(self, mode: int) -> Callable[[float, np.ndarray, np.ndarray], None]:
        n, j, Q_m = self.n, self.j, self.problem.friction.Q_m

        def slipping(t: float, y: np.ndarray, rate: np.ndarray) -> None:
            load = self.load(t, y)
            load[j] -= mode * Q_m
            rate[:n] = y[n:]
            rate[n:] = self.inverse @ load

        def stuck(t: float, y: np.ndarray, rate: np.ndarray) -> None:
            rate[:n] = y[n:]
            rate[j] = rate[n + j] = 0.0
            rate[n + self.keep] = self.stuck_inverse @ self.load(t, y)[self.keep]

        return slipping if mode else stuck

    def watches(self, mode: int) -> tuple[Callable[[float, np.ndarray, np.ndarray], None], int]:
        """Functions whose downward zero ends the mode: another set for each mode."""
        n, j, Q_s = self.n, self.j, self.problem.friction.Q_s

        def speed(t: float, y: np.ndarray, g: np.ndarray) -> None:  # noqa: ARG001 - CVODE's form
            g[0] = mode * y[n + j]

        def grip(t: float, y: np.ndarray, g: np.ndarray) -> None:
            H = self.reaction(t, y)
            g[0], g[1] = Q_s - H, Q_s + H

        return (speed, 1) if mode else (grip, 2)

    def segment(self, mode: int, t: float, end: float, y: np.ndarray) -> tuple[float, np.ndarray]:
        """Integrate in one mode up to its end or to `end`; where it stopped."""
        try:
            from sksundae.cvode import CVODE
        except ModuleNotFoundError as error:
            message = "this peer needs scikit-sundae: pip install scikit-sundae"
            raise RuntimeError(message) from error

        watch, number = self.watches(mode)
        watch.terminal = [True] * number  # type: ignore[attr-defined]
        watch.direction = [-1] * number  # type: ignore[attr-defined]
        solver = CVODE(
            self.rates(mode),
            method="Adams",
            rtol=self.rtol,
            atol=self.atol,
            eventsfn=watch,
            num_events=number,
            max_step=self.max_step,
            max_num_steps=100_000,
        )
        solution = solver.solve(np.array([t, end]), y)
        if not solution.success:
            raise RuntimeError(f"scikit-sundae stopped at t = {solution.t[-1]}: {solution.message}")
        if solution.t_events is None or len(solution.t_events) == 0:
            return end, np.array(solution.y[-1])
        return float(solution.t_events[-1]), np.array(solution.y_events[-1])


def run(
    problem: Any,
    periods: float,
    initial_state: Any = None,
    rtol: float = 1e-11,
    atol: float = 1e-13,
) -> PeerRun:
    """Run `problem` from t = 0 over `periods` forcing periods."""
    peer = _Peer(problem, rtol, atol)
    n, j, friction = peer.n, peer.j, problem.friction
    t, end = 0.0, periods * 2.0 * np.pi / problem.forcing.Omega
    y = np.zeros(2 * n) if initial_state is None else np.array(initial_state, float)
    mode = int(np.sign(y[n + j]))
    if mode == 0:
        H = peer.reaction(t, y)
        mode = 0 if abs(H) <= friction.Q_s else int(np.sign(H))
    times: list[float] = []
    kinds: list[str] = []
    while len(times) < MAX_EVENTS:
        t, y = peer.segment(mode, t, end, y)
        if t >= end:
            return PeerRun(np.array(times), kinds, y)
        y[n + j] = 0.0
        H = peer.reaction(t, y)
        if mode:
            mode = 0 if abs(H) <= friction.Q_s else int(np.sign(H))
            kinds.append("stick" if mode == 0 else "reverse")
        else:
            mode = int(np.sign(H))
            kinds.append(SLIP[mode])
        times.append(t)
    raise RuntimeError(f"{MAX_EVENTS} events before t = {t}: chatter")
