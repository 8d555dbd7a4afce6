"""The law at states worked out by hand, and its roll-outs against an independent fine integration."""

from dataclasses import replace
from math import atan, cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.planning.control_law import (
    ControlLawConfig,
    egocentric,
    roll_out,
    roll_out_one,
    target_pose,
    velocities,
)
from edge.pose import wrap

LAW = ControlLawConfig()
NO_TURNS = replace(LAW, turn_first=10.0, v_min=0.0, r_align=1e-6, r_slow=1e-3)

angle = st.floats(-3.1, 3.1)
pose = st.tuples(st.floats(-3, 3), st.floats(-3, 3), angle)


def test_straight_ahead_is_full_speed_and_no_turn():
    v, omega = velocities(2.0, 0.0, 0.0, 0.6, LAW)
    assert (v, omega) == (0.6, 0.0)


def test_closed_form_at_a_selected_state():
    r, theta, delta = 1.5, 0.4, -0.3
    kappa = -(3.0 * (delta - atan(-1.2 * theta)) + (1 + 1.2 / (1 + (1.2 * theta) ** 2)) * sin(delta)) / r
    v, omega = velocities(r, theta, delta, 0.5, NO_TURNS)
    assert v == pytest.approx(0.5 / (1 + 0.4 * kappa**2))
    assert omega == pytest.approx(kappa * v)


def test_on_the_manifold_the_turn_keeps_the_robot_there():
    """On δ = atan(−k₁θ) Lyapunov's slow subsystem has δ' = −k₁/(1 + (k₁θ)²)·θ' exactly, with θ' = v sin δ / r."""
    for theta in (-1.0, -0.2, 0.5):
        delta, r = atan(-1.2 * theta), 1.0
        v, omega = velocities(r, theta, delta, 0.5, NO_TURNS)
        theta_rate = v * sin(delta) / r
        delta_rate = v * sin(delta) / r + omega
        assert delta_rate == pytest.approx(-1.2 / (1 + (1.2 * theta) ** 2) * theta_rate)


def test_slows_near_the_target_but_not_below_the_least_speed():
    assert velocities(0.4, 0.0, 0.0, 0.6, LAW)[0] == pytest.approx(0.6 * 0.4 / 0.6)
    assert velocities(0.05, 0.0, 0.0, 0.6, LAW)[0] == pytest.approx(LAW.v_min)
    steep = replace(LAW, r_slow=0.05)
    assert velocities(0.1, 0.0, 0.0, 0.6, steep)[0] == pytest.approx((2 * 0.8 * 0.1) ** 0.5)


def test_turns_on_the_spot_off_the_manifold_and_at_the_target():
    assert velocities(1.0, 0.0, 2.0, 0.6, LAW) == (0.0, -LAW.turn_rate)
    v, omega = velocities(*egocentric((0, 0, 0), (0.01, 0.0, 0.2), LAW), 0.6, LAW)
    assert v == 0.0 and omega == pytest.approx(LAW.turn_gain * 0.2)


@given(pose, pose)
def test_target_pose_inverts_egocentric(robot, target):
    if hypot(robot[0] - target[0], robot[1] - target[1]) < 0.05:
        return
    back = target_pose(robot, *egocentric(robot, target, LAW))
    np.testing.assert_allclose(back[:2], target[:2], atol=1e-9)
    assert abs(wrap(back[2] - target[2])) < 1e-9


@given(st.floats(0.0, 5), angle, angle, st.floats(0, 0.6))
def test_never_exceeds_the_limits(r, theta, delta, v_max):
    v, omega = velocities(max(r, 1e-6), theta, delta, v_max, LAW)
    assert 0 <= v <= v_max + 1e-12
    assert abs(omega) <= LAW.omega_max + 1e-9


def fine(start, twist, target, law):
    """The same closed loop at 1 ms, written in the polar coordinates of the paper."""
    x, y, heading = start
    v, omega = twist
    states = [(x, y, heading, v, omega)]
    for step in range(5000):
        if step % 50 == 0:  # the law is sampled every 50 ms, as in the roll-out
            r, theta, delta = egocentric((x, y, heading), target[:3], law)
            want_v, want_omega = velocities(max(r, 1e-6), theta, delta, target[3], law)
            v = min(max(want_v, v - 0.05 * law.brake), v + 0.05 * law.acceleration)
            change = 0.05 * law.angular_acceleration
            omega = min(max(want_omega, omega - change), omega + change)
        x, y, heading = x + 1e-3 * v * cos(heading), y + 1e-3 * v * sin(heading), heading + 1e-3 * omega
        if (step + 1) % 200 == 0:
            states.append((x, y, heading, v, omega))
    return np.array(states).T


@pytest.mark.parametrize("target", [(2, 0.5, 0.3, 0.6), (-1, 1, -2, 0.5), (0.5, -0.8, pi, 0.3), (0, 0, 1.2, 0.0)])
def test_roll_out_agrees_with_a_fine_integration(target):
    start, twist = (0.2, -0.1, 0.4), (0.3, -0.2)
    out = roll_out(start, twist, np.array([target, (1, 1, 1, 0.1)]), 0.1, LAW)
    expected = fine(start, twist, target, LAW)
    assert out.x.shape == (2, 26)
    for name, values, tolerance in zip(("x", "y", "heading"), expected, (0.02, 0.02, 0.05)):
        np.testing.assert_allclose(getattr(out, name)[0], values, atol=tolerance)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.lists(st.tuples(pose, st.floats(-0.4, 0.6)), min_size=1, max_size=5), pose, st.floats(-0.1, 0.6), angle)
def test_single_roll_out_equals_its_row_of_the_batch(targets, robot, v, omega):
    omega = omega / 3
    targets = np.array([[*target, v_max] for target, v_max in targets])
    batch = roll_out(robot, (v, omega), targets, 0.1, LAW)
    for i, target in enumerate(targets):
        # A state on the very edge of a case may fall to either side; a short horizon keeps rounding from growing.
        one = roll_out_one(robot, (v, omega), target, 0.1, LAW)
        for name in ("x", "y", "heading", "v", "omega"):
            np.testing.assert_allclose(getattr(one, name)[0, :6], getattr(batch, name)[i, :6], atol=1e-6)
        np.testing.assert_allclose(one.command[0], batch.command[i], atol=1e-9)


def test_backwards_is_forwards_for_who_looks_the_other_way():
    hasty = replace(LAW, acceleration=LAW.brake)  # it retreats as hard as it brakes
    target, behind = np.array([[-1.0, 0.4, 0.3, -0.4]]), np.array([[-1.0, 0.4, 0.3 + pi, 0.4]])
    back = roll_out((0.1, 0.2, 0.5), (0.3, 0.1), target, 0.1, LAW)
    ahead = roll_out((0.1, 0.2, 0.5 + pi), (-0.3, 0.1), behind, 0.1, hasty)
    for name, shift, sign in (("x", 0, 1), ("y", 0, 1), ("heading", pi, 1), ("v", 0, -1), ("omega", 0, 1)):
        np.testing.assert_allclose(sign * getattr(back, name) + shift, getattr(ahead, name), atol=1e-9)
    assert back.command[0] == pytest.approx([0.3 - 0.1 * LAW.brake, ahead.command[0, 1]])
    assert back.x[0, -1] == pytest.approx(-1.0, abs=0.1)


def test_roll_outs_end_at_the_target_pose():
    targets = np.array([[1.0, 0.2, 0.3, 0.6], [0.8, -0.3, -0.5, 0.6]])
    out = roll_out((0, 0, 0), (0, 0), targets, 0.1, replace(LAW, steps=200))
    assert np.hypot(out.x[:, -1] - targets[:, 0], out.y[:, -1] - targets[:, 1]).max() < 0.06
    assert np.abs(wrap(out.heading[:, -1] - targets[:, 2])).max() < 0.1
