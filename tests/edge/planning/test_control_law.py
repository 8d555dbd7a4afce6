"""The law at states worked out by hand, and its roll-outs against an independent fine integration."""

from dataclasses import replace
from math import atan, cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from edge.planning.control_law import (
    ControlLawConfig,
    control_law,
    egocentric,
    roll_out,
    target_pose,
)
from edge.pose import wrap

LAW = ControlLawConfig()
NO_TURNS = replace(LAW, turn_first=10.0, v_min=0.0, r_align=1e-6, r_slow=1e-3)

angle = st.floats(-3.1, 3.1)
pose = st.tuples(st.floats(-3, 3), st.floats(-3, 3), angle)


def test_straight_ahead_is_full_speed_and_no_turn():
    v, omega = control_law(0.6, LAW)(2.0, 0.0, 0.0)
    assert (v, omega) == (0.6, 0.0)


def test_closed_form_at_a_selected_state():
    r, theta, delta = 1.5, 0.4, -0.3
    kappa = -(3.0 * (delta - atan(-1.2 * theta)) + (1 + 1.2 / (1 + (1.2 * theta) ** 2)) * sin(delta)) / r
    v, omega = control_law(0.5, NO_TURNS)(r, theta, delta)
    assert v == pytest.approx(0.5 / (1 + 0.4 * kappa**2))
    assert omega == pytest.approx(kappa * v)


def test_on_the_manifold_the_turn_keeps_the_robot_there():
    """On δ = atan(−k₁θ) Lyapunov's slow subsystem has δ' = −k₁/(1 + (k₁θ)²)·θ' exactly, with θ' = v sin δ / r."""
    for theta in (-1.0, -0.2, 0.5):
        delta, r = atan(-1.2 * theta), 1.0
        v, omega = control_law(0.5, NO_TURNS)(r, theta, delta)
        theta_rate = v * sin(delta) / r
        delta_rate = v * sin(delta) / r + omega
        assert delta_rate == pytest.approx(-1.2 / (1 + (1.2 * theta) ** 2) * theta_rate)


def test_slows_near_the_target_but_not_below_the_least_speed():
    assert control_law(0.6, LAW)(0.4, 0.0, 0.0)[0] == pytest.approx(0.6 * 0.4 / 0.6)
    assert control_law(0.6, LAW)(0.05, 0.0, 0.0)[0] == pytest.approx(LAW.v_min)
    steep = replace(LAW, r_slow=0.05)
    assert control_law(0.6, steep)(0.1, 0.0, 0.0)[0] == pytest.approx((2 * 0.8 * 0.1) ** 0.5)


def test_turns_on_the_spot_off_the_manifold_and_at_the_target():
    assert control_law(0.6, LAW)(1.0, 0.0, 2.0) == (0.0, -LAW.turn_rate)
    v, omega = control_law(0.6, LAW)(*egocentric((0, 0, 0), (0.01, 0.0, 0.2), LAW))
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
    v, omega = control_law(v_max, LAW)(max(r, 1e-6), theta, delta)
    assert 0 <= v <= v_max + 1e-12
    assert abs(omega) <= LAW.omega_max + 1e-9


@given(st.floats(0.05, 5), angle, angle, st.floats(0.01, 0.6))
def test_it_is_the_least_of_the_papers_speed_the_ramps_and_what_the_turn_allows(r, theta, delta, v_max):
    off = delta - np.arctan(-LAW.k1 * theta)
    assume(abs(off) < LAW.turn_first)
    kappa = -(LAW.k2 * off + (1 + LAW.k1 / (1 + (LAW.k1 * theta) ** 2)) * np.sin(delta)) / r
    slow = max(min(v_max * r / LAW.r_slow, np.sqrt(2 * LAW.acceleration * r)), min(LAW.v_min, v_max))
    expected = min(v_max / (1 + LAW.beta * kappa**2), slow, LAW.omega_max / max(abs(kappa), 1e-9))
    v, omega = control_law(v_max, LAW)(r, theta, delta)
    assert v == pytest.approx(expected) and omega == pytest.approx(kappa * expected)


def fine(start, twist, target, law):
    """The same closed loop at 1 ms, written in the polar coordinates of the paper."""
    x, y, heading = start
    v, omega = twist
    states = [(x, y, heading, v, omega)]
    for step in range(5000):
        if step % 50 == 0:  # the law is sampled every 50 ms, as in the roll-out
            r, theta, delta = egocentric((x, y, heading), target[:3], law)
            want_v, want_omega = control_law(target[3], law)(max(r, 1e-6), theta, delta)
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
