"""Draws docs/figures/drive.png: the paper's drive with the signs and angles of docs/model.md.

Geometry comes from beltsim itself (`load_drive(...).layout`), so the picture shows what the
program uses. Run from the repository root: python docs/figures/drive.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle

import beltsim
from beltsim.drive import Layout

ROOT = Path(__file__).resolve().parents[2]
PICTURE = Path(__file__).with_suffix(".png")
BELT, ARM, SIGN, FORCE = "#333333", "#b5651d", "#1f5fa8", "#b03060"


def arrow(
    ax: Axes, start: np.ndarray, step: np.ndarray, colour: str, text: str = "", aside: float = 0.0
) -> None:
    """A vector from `start`, named beyond its tip, or `aside` to the left of the tip."""
    ax.annotate(
        "",
        xy=start + step,
        xytext=start,
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.4, "shrinkA": 0, "shrinkB": 0},
        zorder=5,
    )
    along = step / np.linalg.norm(step)
    left = np.array([-along[1], along[0]])
    tip = start + step + (aside * left if aside else 0.014 * along)
    if text:
        ax.text(*tip, text, color=colour, ha="center", va="center", fontsize=10, zorder=6)


def write(ax: Axes, spot: np.ndarray, text: str, colour: str, slope: float = 0.0) -> None:
    """Centred text, turned by `slope` degrees."""
    ax.text(*spot, text, color=colour, ha="center", va="center", fontsize=9.5, rotation=slope)


def turn(
    ax: Axes, centre: np.ndarray, radius: float, start: float, end: float, colour: str
) -> None:
    """A turning arrow from angle `start` to `end`, degrees; clockwise when end < start."""
    ax.add_patch(Arc(centre, 2 * radius, 2 * radius, theta1=min(start, end), theta2=max(start, end),
                     color=colour, lw=1.4, zorder=5))  # fmt: skip
    angle = np.radians(end)
    tip = centre + radius * np.array([np.cos(angle), np.sin(angle)])
    tangent = np.sign(end - start) * np.array([-np.sin(angle), np.cos(angle)])
    arrow(ax, tip, 0.002 * tangent, colour)


def draw_belt(ax: Axes, layout: Layout) -> None:
    """Pulleys, spans, wraps and the arm."""
    for j, (centre, radius) in enumerate(zip(layout.center_m, layout.radius_m, strict=True)):
        ax.add_patch(Circle(centre, radius, facecolor="#eef1f4", edgecolor="#9aa5b1", lw=1.0))
        ax.plot(*centre, "+", color="#9aa5b1", ms=5)
        arrive, leave = layout.span_end_m[j - 1] - centre, layout.span_start_m[j] - centre
        first = np.arctan2(arrive[1], arrive[0])
        angles = first + layout.side[j] * np.linspace(0.0, layout.wrap_rad[j], 80)
        ax.plot(centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles),
                color=BELT, lw=2.2)  # fmt: skip
        assert np.allclose(leave, radius * np.array([np.cos(angles[-1]), np.sin(angles[-1])]))
    for i in range(len(layout.radius_m)):
        ax.plot(*np.transpose([layout.span_start_m[i], layout.span_end_m[i]]), color=BELT, lw=2.2)
    pivot, centre = layout.pivot_m, layout.center_m[layout.arm]
    ax.plot(*np.transpose([pivot, centre]), color=ARM, lw=4, alpha=0.75, solid_capstyle="round")
    ax.plot(*pivot, "o", color=ARM, ms=7, zorder=6)


def draw_overview(ax: Axes, layout: Layout) -> None:
    """Left: list order, spans, unit vectors, travel."""
    draw_belt(ax, layout)
    names = ("crank, pulley 1", "pulley 2 = $T$", "pulley 3")
    for j, (centre, name) in enumerate(zip(layout.center_m, names, strict=True)):
        outside = -layout.side[j] * (layout.radius_m[j] + 0.022)
        write(ax, centre + np.array([0.0, outside]), name, "black")
        with_travel = (150, 30) if layout.side[j] > 0 else (30, 150)
        turn(ax, centre, 0.6 * layout.radius_m[j], *with_travel, SIGN)
        beside = np.array([0.045, 0.0]) if j == 2 else np.array([0.0, -0.015])
        write(ax, centre + beside, rf"$\theta_{j + 1}$", SIGN)
    for i, (along, normal) in enumerate(zip(layout.direction, layout.normal, strict=True)):
        start, end = layout.span_start_m[i], layout.span_end_m[i]
        middle = 0.5 * (start + end)
        arrow(ax, middle, 0.055 * along, SIGN, f"$u_{i + 1}$", aside=0.014)
        arrow(ax, middle, 0.03 * normal, SIGN, f"$v_{i + 1}$", aside=0.012)
        slope = float(np.degrees(np.arctan(along[1] / along[0])))
        write(ax, middle - 0.018 * normal, f"span {i + 1}", BELT, slope)
        if i != 0:
            arrow(ax, start + 0.2 * (end - start) - 0.012 * normal, -0.05 * along, FORCE)
    write(ax, np.array([0.28, -0.078]), "belt travels clockwise (red): against $u$", FORCE)
    ax.set_xlim(-0.06, 0.66)
    ax.set_ylim(-0.09, 0.17)


def draw_arm(ax: Axes, layout: Layout) -> None:
    """Right: the arm, its angles and the belt's pull on its pulley."""
    draw_belt(ax, layout)
    pivot, centre = layout.pivot_m, layout.center_m[layout.arm]
    along = (centre - pivot) / np.linalg.norm(centre - pivot)
    base = float(np.degrees(np.arctan2(along[1], along[0])))
    for number, i, beta, size in ((1, 0, layout.beta_1, 0.016), (2, 1, layout.beta_2, 0.031)):
        direction = layout.direction[i]
        ax.plot(*np.transpose([pivot, pivot + 0.045 * direction]), ":", color=SIGN, lw=1.2)
        write(ax, pivot + 0.053 * direction, f"$u_{number}$", SIGN)
        turn(ax, pivot, size, base - np.degrees(beta), base, SIGN)
        middle = np.radians(base - 0.5 * np.degrees(beta))
        ray = np.array([np.cos(middle), np.sin(middle)])
        write(ax, pivot + (size + 0.007) * ray, rf"$\beta_{number}$", SIGN)
    ax.plot(*np.transpose([centre, centre + 0.02 * along]), ":", color=ARM, lw=1.2)
    arrow(ax, centre, 0.05 * layout.arm_normal, ARM, r"$\nu$")
    turn(ax, pivot, layout.arm_length_m * 0.62, base - 8, base + 12, ARM)
    write(ax, pivot + np.array([0.058, 0.022]), r"$\theta_t$", ARM)
    write(ax, pivot + np.array([0.0, 0.015]), "pivot $b$", ARM)
    first, second = layout.span_end_m[0], layout.span_start_m[1]  # on pulley T
    arrow(ax, first, -0.05 * layout.direction[0], FORCE, "$T_1$", aside=0.010)
    arrow(ax, second, 0.05 * layout.direction[1], FORCE, "$T_2$", aside=0.010)
    ax.set_xlim(0.185, 0.445)
    ax.set_ylim(-0.01, 0.145)


def main(path: Path = PICTURE) -> None:
    """Draw both panels and write the picture, beside this file unless told otherwise."""
    layout = beltsim.load_drive(ROOT / "examples" / "zhu_parker_2008.toml").layout
    mpl.rcParams.update({"mathtext.fontset": "cm", "font.size": 10})
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11, 3.3), width_ratios=[1.5, 1.0], layout="constrained"
    )
    draw_overview(left, layout)
    draw_arm(right, layout)
    for ax in (left, right):
        ax.set_aspect("equal")
        ax.axis("off")
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main()
