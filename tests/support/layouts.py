"""Random drives that are sound, and the same drive seen in other ways.

`random_drive(rng)` draws until the layout has no fault, each pulley has at least `MIN_WRAP` of
contact, the arm is not in line with the belt's pull, and every span keeps a tension of at least
`MIN_TENSION` P0 in the string limit of the steady state. `drives()` is the same as a hypothesis
strategy. The `turned`, `shifted`, `renumbered`, `mirrored` and `rescaled` drives are the same
machine: what a model computes from them must agree.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from beltsim.drive import Drive
from beltsim.drive.faults import layout_faults
from beltsim.drive.tracing import trace
from beltsim.drive.tracing import turned as quarter_turned

MIN_WRAP = np.radians(10.0)
MIN_TENSION = 0.3
MIN_PRELOAD = 0.2


def random_drive(
    rng: np.random.Generator,
    n_pulleys: int | None = None,
    travel: str | None = None,
    arm: bool = True,
    arm_side: str | None = None,
    torques: bool = True,
    epsilon: float | None = None,
) -> Drive:
    """A sound drive of 3 to 8 pulleys; what is None is drawn.

    `arm=False` gives fixed centres, `arm_side` the side of the tensioner pulley, `torques=False`
    leaves out the accessory torques. The crank is any pulley but the tensioner's.
    """
    n = int(rng.integers(3, 9)) if n_pulleys is None else n_pulleys
    sense = str(rng.choice(["cw", "ccw"])) if travel is None else travel
    for _ in range(20_000):
        center, radius, side = _loop(rng, n, arm_side if arm else None)
        if center is None:
            continue
        roles = _roles(rng, side, arm, arm_side)
        if roles is None:
            continue
        pulleys = [
            {
                "name": f"p{j}",
                "role": roles[j],
                "side": "inside" if side[j] > 0 else "back",
                "center_m": center[j].tolist(),
                "radius_m": float(radius[j]),
                "inertia_kg_m2": float(10.0 ** rng.uniform(-3.7, -1.7)),
            }
            for j in range(n)
        ]
        drive = _dressed(rng, pulleys, sense, center, side, radius, torques, epsilon)
        if drive is not None:
            return drive
    raise AssertionError("no sound layout drawn in 20000 attempts")


@st.composite
def drives(draw: st.DrawFn, **fixed: Any) -> Drive:
    """Strategy for sound drives; keywords as for `random_drive`."""
    choices: dict[str, st.SearchStrategy[Any]] = {
        "n_pulleys": st.integers(3, 8),
        "travel": st.sampled_from(["cw", "ccw"]),
        "arm_side": st.sampled_from(["inside", "back"]),
    }
    chosen = {key: draw(value) for key, value in choices.items() if key not in fixed}
    return random_drive(np.random.default_rng(draw(st.integers(0, 2**32 - 1))), **chosen, **fixed)


def _loop(rng, n, arm_side):
    """Centres, radii and sides of a sound loop, or Nones for a draw that failed.

    Pulleys inside the loop first; then some of their spans are pressed in by a back-side pulley.
    """
    n_back = int(rng.integers(1 if arm_side == "back" else 0, n // 2 + 1))
    n_inside = n - n_back
    radius = rng.uniform(0.025, 0.09, n_inside)
    angle = 2.0 * np.pi * (np.arange(n_inside) + rng.uniform(-0.35, 0.35, n_inside)) / n_inside
    distance = rng.uniform(0.2, 0.4, n_inside) * (1.0 + 0.08 * n)
    center = distance[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    center += rng.uniform(-0.3, 0.3, 2)
    path = trace(center, radius, np.ones(n_inside))
    if not np.isfinite(path.length).all():
        return None, None, None
    pressed = set(rng.permutation(n_inside)[:n_back].tolist())
    rows = []
    for j in range(n_inside):
        rows.append((*center[j], radius[j], 1.0))
        if j in pressed:
            small, depth = rng.uniform(0.025, 0.05), rng.uniform(0.01, 0.06)
            start = center[j] - radius[j] * path.normal[j]
            touch = start + rng.uniform(0.25, 0.75) * path.length[j] * path.direction[j]
            rows.append((*(touch + (depth - small) * path.normal[j]), small, -1.0))
    first = int(rng.integers(n))
    table = np.roll(np.array(rows), first, axis=0)
    center, radius, side = table[:, :2], table[:, 2], table[:, 3]
    wrap = trace(center, radius, side).wrap
    if not wrap.min() > MIN_WRAP or layout_faults([""] * n, center, radius, side):
        return None, None, None
    return center, radius, side


def _roles(rng, side, arm, arm_side):
    """Roles with a crank and, if wanted, an arm on the wanted side; None when there is none."""
    n = len(side)
    roles = ["fixed"] * n
    free = list(range(n))
    if arm:
        wanted = {"inside": 1.0, "back": -1.0}.get(arm_side)
        places = [j for j in free if wanted is None or side[j] == wanted]
        if not places:
            return None
        tensioner = int(rng.choice(places))
        roles[tensioner] = "arm"
        free.remove(tensioner)
    roles[int(rng.choice(free))] = "crank"
    return roles


def _dressed(rng, pulleys, sense, center, side, radius, torques, epsilon):
    """A drive on this loop, or None when the arm or the tensions are not usable."""
    n = len(pulleys)
    path = trace(center, radius, side)
    roles = [p["role"] for p in pulleys]
    tension = float(rng.uniform(200.0, 600.0))
    share = rng.uniform(0.0, 0.6 / n, n) if torques else np.zeros(n)
    share[roles.index("crank")] = 0.0
    for pulley, part in zip(pulleys, share, strict=True):
        pulley["accessory_torque_N_m"] = float(part * tension * pulley["radius_m"])
    density = float(rng.uniform(0.06, 0.15))
    mean = float(path.length.mean())
    speed = float(rng.uniform(0.05, 0.6))  # of the belt, in wave speeds
    alpha = float(rng.choice([1.5, 2.0, 3.0]))
    firing = speed * alpha * mean / radius[roles.index("crank")]
    tables: dict[str, Any] = {
        "name": "random",
        "crank_rotation": sense,
        "pulleys": pulleys,
        "belt": {
            "EA_N": float(10.0 ** rng.uniform(4.7, 5.3)),
            "epsilon": float(rng.uniform(0.005, 0.03)) if epsilon is None else epsilon,
            "mass_per_length_kg_m": density,
            "initial_tension_N": tension,
        },
        "damping": {"ratio": float(rng.uniform(0.02, 0.08))},
        "operating_point": {"Omega": float(firing)},
        "excitation": {"firing_order": alpha, "speed_fluctuation": float(rng.uniform(0.02, 0.1))},
    }
    lever = 0.0
    if "arm" in roles:
        j = roles.index("arm")
        length, heading = rng.uniform(0.05, 0.12), rng.uniform(0.0, 2.0 * np.pi)
        reach = length * np.array([np.cos(heading), np.sin(heading)])
        nu = quarter_turned(reach / length)
        lever = float(nu @ (path.direction[j] - path.direction[j - 1]))
        if abs(lever) < MIN_PRELOAD:
            return None
        friction = float(rng.uniform(0.0, 0.6) * abs(lever) * tension * length)
        tables["tensioner"] = {
            "pivot_m": (center[j] - reach).tolist(),
            "arm_inertia_kg_m2": float(10.0 ** rng.uniform(-3.0, -2.3)),
            "spring_rate_N_m_per_rad": float(rng.uniform(15.0, 50.0)),
            "friction_torque_N_m": friction,
            "static_friction_torque_N_m": friction * float(rng.uniform(1.0, 1.3)),
        }
    drive = Drive(**tables)
    return drive if smallest_string_tension(drive) >= MIN_TENSION else None


def smallest_string_tension(drive: Drive) -> float:
    """Smallest span tension T_i in P0 of the string without bending, at the operating point.

    The mean tension is sought such that the stretch of the spans equals the belt that the arm
    lets out while it balances spring and belt.
    """
    layout = drive.layout if drive.crank_rotation == "cw" else drive.layout.mirrored()
    belt, length = drive.belt, layout.span_length_m
    P0, gamma = belt.initial_tension_N, belt.EA_N / belt.initial_tension_N
    s = layout.radius_m[layout.crank] * drive.Omega / (
        drive.excitation.firing_order * drive.mean_span_length_m
    )  # fmt: skip
    M = -layout.accessory_torque_N_m / (P0 * layout.radius_m)
    offset = np.concatenate([[0.0], np.cumsum(M[1:])])
    # crank: its reaction closes the loop, so the tensions jump there by what is left
    if layout.crank != 0:
        offset[layout.crank :] -= M.sum()
    arm = np.zeros(layout.n)
    stiffness, pull = 1.0, np.zeros(layout.n)
    if layout.arm is not None:
        j, r_t = layout.arm, layout.arm_length_m
        pull[j - 1] += np.sin(layout.beta_1)
        pull[j] -= np.sin(layout.beta_2)
        arm = -r_t * pull
        stiffness = drive.tensioner.spring_rate_N_m_per_rad / (P0 * r_t)
    # unknowns: p of the first span, arm angle
    matrix = [[length.sum() / gamma, -arm.sum()], [-pull.sum(), stiffness]]
    right = [(length @ (1.0 - offset)) / gamma, pull @ (offset - s**2) - pull.sum()]
    p, _ = np.linalg.solve(matrix, right)
    return float((p + offset - s**2).min())


def with_coordinates(
    drive: Drive, move: Any, order: list[int] | None = None, **tables: Any
) -> Drive:
    """`drive` with every point moved by `move` and the pulleys listed in `order`."""
    data = drive.model_dump(exclude_none=True)
    for pulley in data["pulleys"]:
        pulley["center_m"] = np.asarray(move(np.array(pulley["center_m"]))).tolist()
    if "tensioner" in data:
        pivot = np.array(data["tensioner"]["pivot_m"])
        data["tensioner"]["pivot_m"] = np.asarray(move(pivot)).tolist()
    if order is not None:
        data["pulleys"] = [data["pulleys"][j] for j in order]
    return Drive(**data | tables)


def turned(drive: Drive, angle: float) -> Drive:
    """`drive` turned about the origin by `angle` (rad)."""
    c, s = np.cos(angle), np.sin(angle)
    return with_coordinates(drive, lambda x: np.array([[c, -s], [s, c]]) @ x)


def shifted(drive: Drive, dx: float, dy: float) -> Drive:
    """`drive` moved as a whole."""
    return with_coordinates(drive, lambda x: x + np.array([dx, dy]))


def renumbered(drive: Drive, first: int) -> Drive:
    """`drive` with its list beginning at pulley `first`."""
    n = len(drive.pulleys)
    tables = {}
    if drive.overrides is not None and drive.overrides.span_lengths_m is not None:
        lengths = [drive.overrides.span_lengths_m[(first + k) % n] for k in range(n)]
        tables["overrides"] = drive.overrides.model_dump() | {"span_lengths_m": lengths}
    order = [(first + k) % n for k in range(n)]
    return with_coordinates(drive, lambda x: x, order, **tables)


def mirrored(drive: Drive) -> Drive:
    """`drive` seen from behind: y -> -y, list reversed, travel the other way; no overrides."""
    assert drive.overrides is None
    order = list(range(len(drive.pulleys)))[::-1]
    other = "ccw" if drive.crank_rotation == "cw" else "cw"
    return with_coordinates(drive, lambda x: x * np.array([1.0, -1.0]), order, crank_rotation=other)


def rescaled(drive: Drive, length: float, mass: float, time: float) -> Drive:
    """The numbers of `drive` in other units: each dimension is multiplied by its factor.

    Dimensionless keys (epsilon, Omega, ratios) stay; the results of a dimensionless model must not
    change.
    """
    force, inertia = mass * length / time**2, mass * length**2
    torque = force * length
    factors = {
        "center_m": length,
        "pivot_m": length,
        "radius_m": length,
        "inertia_kg_m2": inertia,
        "arm_inertia_kg_m2": inertia,
        "accessory_torque_N_m": torque,
        "friction_torque_N_m": torque,
        "static_friction_torque_N_m": torque,
        "spring_rate_N_m_per_rad": torque,
        "EA_N": force,
        "initial_tension_N": force,
        "EI_N_m2": force * length**2,
        "mass_per_length_kg_m": mass / length,
        "rpm": 1.0 / time,
        "span_lengths_m": length,
        "arm_length_m": length,
    }

    def scaled(key: str, entry: Any) -> Any:
        if isinstance(entry, dict):
            return {name: scaled(name, value) for name, value in entry.items()}
        if isinstance(entry, list | tuple):
            return [scaled(key, value) for value in entry]
        return entry * factors[key] if key in factors else entry

    return Drive(**scaled("", drive.model_dump(exclude_none=True)))
