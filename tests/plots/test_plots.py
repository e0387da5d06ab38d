"""The figures show the right numbers with units, need no display and touch no global state."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from support import responses

from beltsim import plots
from beltsim.drive import presets
from beltsim.errors import InvalidProblemError, ResultFileError
from beltsim.friction import Coulomb

SCALE_RATE, SCALE_TORQUE = 1.0 / 6.4914e-3, 29.1


def texts(figure):
    from matplotlib.text import Text

    return "\n".join(text.get_text() for text in figure.findobj(Text))


def lines(axes, colour):
    return [line for line in axes.get_lines() if line.get_color() == colour]


@pytest.fixture
def swing():
    return responses.stick_slip(periods=4)


def test_arm_motion_draws_si_values_of_the_last_two_periods(swing):
    figure = plots.arm_motion(swing, crank_rpm=3089.0)
    upper, lower = figure.axes
    (velocity,), (torque,) = lines(upper, "#0072B2"), lines(lower, "#D55E00")
    period_ms = swing.problem.period * 6.4914
    assert velocity.get_xdata()[0] == 0.0
    assert velocity.get_xdata()[-1] == pytest.approx(2.0 * period_ms)
    last = swing.t >= 2.0 * swing.problem.period * (1.0 - 1e-12)
    assert velocity.get_ydata().max() == pytest.approx(swing.q_dot[last, 1].max() * SCALE_RATE)
    assert torque.get_ydata().max() == pytest.approx(3.5 * SCALE_TORQUE)
    said = texts(figure)
    for word in ("3089 rpm", "(rad/s)", "(N m)", "(ms)", "crank angle (deg)", "+$Q_m$", "+$Q_s$"):
        assert word in said


def test_the_curves_pass_through_the_events(swing):
    """A release jumps between two samples; the curve has both torques at the same time."""
    old = swing.events
    before, after = np.full(len(old), 4.0), np.full(len(old), -3.5)
    shifted = replace(old, t=old.t + 1e-3, torque_before=before, torque_after=after)
    figure = plots.arm_motion(replace(swing, events=shifted))
    (torque,) = lines(figure.axes[1], "#D55E00")
    (velocity,) = lines(figure.axes[0], "#0072B2")
    t, values = torque.get_xdata(), torque.get_ydata()
    assert np.all(np.diff(t) >= 0.0)
    jumps = np.flatnonzero(np.diff(t) == 0.0)
    inside = shifted.t[(shifted.t > swing.t[1000]) & (shifted.t < swing.t[-1])]
    assert len(jumps) == len(inside)
    np.testing.assert_allclose(values[jumps], 4.0 * SCALE_TORQUE)
    np.testing.assert_allclose(values[jumps + 1], -3.5 * SCALE_TORQUE)
    np.testing.assert_array_equal(velocity.get_ydata()[jumps], 0.0)


def test_sticking_is_shaded_where_the_arm_sticks(swing):
    from matplotlib.patches import Rectangle

    figure = plots.arm_motion(swing)
    bands = [p for p in figure.axes[0].patches if isinstance(p, Rectangle)]
    width = sum(band.get_width() for band in bands)
    assert len(bands) == 4
    assert width / figure.axes[0].get_xlim()[1] == pytest.approx(2 * responses.STICK)


def test_levels_lie_at_the_friction_torques(swing):
    lower = plots.arm_motion(swing).axes[1]
    dashed = {line.get_ydata()[0] for line in lower.get_lines() if line.get_linestyle() == "--"}
    dotted = {line.get_ydata()[0] for line in lower.get_lines() if line.get_linestyle() == ":"}
    assert dashed == {3.5 * SCALE_TORQUE, -3.5 * SCALE_TORQUE}
    assert dotted == {4.0 * SCALE_TORQUE, -4.0 * SCALE_TORQUE}


def test_without_scales_nothing_is_called_si(swing):
    problem = replace(swing.problem, scales=None)
    said = texts(plots.arm_motion(replace(swing, problem=problem), crank_rpm=3089.0))
    assert "(N m)" not in said
    assert "(deg)" not in said
    assert "problem units" in said


def test_a_short_run_is_drawn_whole():
    response = responses.stick_slip(periods=1)
    figure = plots.arm_motion(response)
    period_ms = response.problem.period * 6.4914
    assert figure.axes[1].get_xlim()[1] == pytest.approx(period_ms)


def test_what_cannot_be_drawn_is_said(swing):
    none = np.zeros((0, 2))
    empty = replace(swing, t=np.zeros(0), q=none, q_dot=none, friction_torque=np.zeros(0))
    with pytest.raises(InvalidProblemError, match="0 samples"):
        plots.arm_motion(empty)
    with pytest.raises(InvalidProblemError, match="no friction joint"):
        plots.arm_motion(responses.bare())
    with pytest.raises(InvalidProblemError, match="no observable"):
        plots.span_tensions(responses.bare())


def test_span_tensions_are_in_newtons(swing):
    figure = plots.span_tensions(swing, crank_rpm=800.0)
    (line,) = [one for one in figure.axes[0].get_lines() if len(one.get_xdata()) > 2]
    tension = swing.observe("tension of span 1")[-1001:] * 300.0
    np.testing.assert_allclose(line.get_ydata(), tension)
    assert "span tension (N)" in texts(figure)


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_layout_names_everything_and_shows_the_travel(travel):
    drive = presets.zhu_parker_2008().changed(crank_rotation=travel)
    figure = plots.layout(drive)
    said = texts(figure)
    for pulley in drive.pulleys:
        assert pulley.name in said
    assert "(crank)" in said
    assert "pivot" in said
    assert {"cw": "travels clockwise", "ccw": "travels counter-clockwise"}[travel] in said
    arrow = next(t for t in figure.axes[0].texts if hasattr(t, "arrow_patch"))
    way = np.subtract(arrow.xy, arrow.get_position()) @ drive.layout.direction[0]
    assert way < 0.0 if travel == "cw" else way > 0.0


def test_layout_without_a_tensioner():
    paper = presets.zhu_parker_2008().model_dump(exclude_none=True)
    paper["pulleys"] = [dict(p, role=p["role"].replace("arm", "fixed")) for p in paper["pulleys"]]
    del paper["tensioner"], paper["overrides"]
    from beltsim.drive import Drive

    assert "pivot" not in texts(plots.layout(Drive(**paper)))


def test_labels_of_the_layout_do_not_overlap():
    figure = plots.layout(presets.zhu_parker_2008())
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure).draw()
    boxes = [t.get_window_extent() for t in figure.axes[0].texts if t.get_text()]
    for i, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[:i])


def test_pictures_are_written_whole_or_not_at_all(tmp_path, swing):
    figure = plots.arm_motion(swing)
    assert plots.save_figure(figure, tmp_path / "arm.png").read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(ResultFileError, match="cannot write"):
        plots.save_figure(figure, tmp_path / "arm.png" / "arm.png")
    assert [file.name for file in tmp_path.iterdir()] == ["arm.png"]


def test_no_display_and_no_pyplot(tmp_path):
    """In a process of its own: pyplot, the module with the global state, is never loaded."""
    code = (
        "import sys; sys.path[:0] = sys.argv[2:]\n"
        "from support import responses\nfrom beltsim import plots\n"
        "plots.save_figure(plots.arm_motion(responses.stick_slip()), sys.argv[1])\n"
        "print('matplotlib.pyplot' in sys.modules)"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "arm.png"), *filter(None, sys.path)],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)},
    )
    assert run.stdout.strip() == "False"


def test_names_are_drawn_as_they_stand(tmp_path, swing):
    """Dollar signs begin no formula, and letters that the font lacks give no warning."""
    tables = presets.zhu_parker_2008().model_dump(exclude_none=True)
    tables["name"] = "A$_{B$C 皮带"
    for pulley, name in zip(tables["pulleys"], ("$x", "a^$b_{", "Öl 油"), strict=True):
        pulley["name"] = name
    from beltsim.drive import Drive

    drive = Drive(**tables)
    plots.save_figure(plots.layout(drive), tmp_path / "layout.png")
    plots.save_figure(plots.arm_motion(swing, title=drive.name), tmp_path / "arm.png")
    plots.save_figure(plots.span_tensions(swing, title=drive.name), tmp_path / "tensions.png")
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize("seed", range(6))
def test_layouts_of_random_drives(seed):
    """Every pulley is named inside the axes, and no name lies on another."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from support.layouts import random_drive

    drive = random_drive(np.random.default_rng(seed))
    figure = plots.layout(drive)
    FigureCanvasAgg(figure).draw()
    axes = figure.axes[0]
    boxes = [t.get_window_extent() for t in axes.texts if t.get_text()]
    # a pixel of tolerance: the width of text is estimated
    frame = axes.get_window_extent().padded(1.0)
    assert len(boxes) == 2 * drive.layout.n + (drive.layout.arm is not None)
    for box in boxes:
        assert frame.x0 <= box.x0
        assert box.x1 <= frame.x1
        assert frame.y0 <= box.y0
        assert box.y1 <= frame.y1
    for i, one in enumerate(boxes):
        assert not any(one.padded(-1.0).overlaps(other) for other in boxes[:i])


def test_a_joint_of_ones_own_matrices_is_called_by_its_label(swing):
    own = replace(swing.problem, labels=("shaken", "rubbing"), scales=None)
    figure = plots.arm_motion(replace(swing, problem=own))
    said = texts(figure)
    assert "Joint rubbing" in said
    assert "velocity of rubbing" in said
    assert "Tensioner" not in said


def test_event_phases_explain_the_line_and_the_dots(swing):
    orbit = replace(swing, window=(0.0, swing.problem.period))
    reversing = replace(orbit, events=replace(orbit.events, kind=["reverse"] * len(orbit.events)))
    for orbits, expected in (([orbit], False), ([orbit, reversing], True)):
        figure = plots.event_phases(orbits, 2.0, "a")
        words = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
        assert "can stay locked from" in words  # static friction exceeds the kinetic
        assert ("reverses" in words) is expected


def test_event_phases_lock_for_good_without_extra_static_friction(swing):
    problem = swing.problem.with_friction(Coulomb(0.5))
    orbit = replace(swing, problem=problem, window=(0.0, problem.period))
    figure = plots.event_phases([orbit], 2.0)
    words = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert "locked from" in words
