"""Roll-outs past a body that moves, by hand."""

import cv2
import numpy as np
import pytest

from edge.mapping.grid import GridFrame
from edge.perception.movers import Mover
from edge.planning.control_law import RollOuts
from edge.planning.encounter import EncounterConfig, encounter
from edge.planning.mpepc import Mpepc
from edge.planning.trajectory_cost import CostConfig, survival

CONFIG = EncounterConfig()
FRAME = GridFrame((-3.0, -3.0), 0.05, (120, 120))


def line(v, steps=25):
    """From the origin along x at constant speed."""
    t = 0.2 * np.arange(steps + 1)[None]
    zero = np.zeros_like(t)
    return RollOuts(v * t, zero, zero, v + zero, zero, np.array([[v, 0.0]]))


def mover(place, velocity, doubt=0.0, radius=0.25):
    return Mover(np.array(place, float), np.array(velocity, float), doubt, radius)


def test_it_is_the_formula():
    walker, v = mover((1.5, 1.5), (-0.1, -0.6), doubt=0.2), 0.4
    expected = []
    for i in range(26):
        t = 0.2 * i
        gap = np.hypot(v * t - (1.5 - 0.1 * t), -(1.5 - 0.6 * t)) - 0.18 - 0.25
        d = max(0.0, gap - (CONFIG.margin + CONFIG.margin_per_speed * v))
        expected.append(np.exp(-(d**2) / (CONFIG.sigma**2 + (0.2 * t) ** 2)))
    np.testing.assert_allclose(encounter(line(v), walker, 0.18, 0.2, CONFIG)[0], expected, atol=1e-12)
    assert expected[0] < 1e-6 and max(expected) == 1.0


def test_what_counts_is_being_there_at_the_same_time():
    out = line(0.5)  # at x = 1 after 2 s
    meeting, early, late = (mover((1.0, y), (0.0, 1.0)) for y in (-2.0, 1.5, -4.5))
    harm = [encounter(out, walker, 0.18, 0.2, CONFIG).max() for walker in (meeting, early, late)]
    assert harm[0] == 1.0 and harm[1] < 1e-3 and harm[2] < 1e-3
    assert encounter(line(0.0), meeting, 0.18, 0.2, CONFIG).max() < 1e-3  # and who waits is not met


def test_doubt_of_the_velocity_makes_the_future_dangerous_and_not_the_present():
    sure, unsure = (encounter(line(0.0), mover((1.5, 0), (0, 0), doubt), 0.18, 0.2, CONFIG)[0] for doubt in (0.0, 0.8))
    assert sure.max() < 1e-6 and unsure[0] < 1e-6 and unsure[5] > 0.1 and (np.diff(unsure) >= 0).all()


def test_who_stands_too_near_may_leave_but_not_come_nearer():
    close = mover((-0.40, 0.0), (0, 0))  # 3 cm inside of it
    assert encounter(line(0.3), close, 0.18, 0.2, CONFIG).max() < 0.01
    assert encounter(line(-0.3), close, 0.18, 0.2, CONFIG).max() == 1.0


def test_survival_is_of_the_map_and_of_all_movers():
    free = np.full(FRAME.shape, 9.0, np.float32)
    walkers = [mover((1.0, -2.0), (0.0, 0.9), 0.1), mover((2.0, 2.0), (0.0, -0.4), 0.1)]
    out = line(0.4)
    alone = survival(out, free, FRAME, CostConfig())
    expected = np.prod([1 - encounter(out, walker, 0.18, 0.2, CONFIG)[:, 1:] for walker in walkers], axis=0)
    np.testing.assert_allclose(survival(out, free, FRAME, CostConfig(), walkers), alone * expected.cumprod(axis=1))
    assert expected.min() < 0.2


def drive(walker, seconds, start=(0.0, 0.0, 0.0), path=((0.0, 0.0), (2.5, 0.0)), occupied=None):
    """MPEPC in an empty room, an ideal base, and somebody who walks on; closest gap [m] and poses ``(T, 3)``."""
    occupied = np.zeros(FRAME.shape, bool) if occupied is None else occupied
    occupied[[0, -1]] = occupied[:, [0, -1]] = True
    clearance = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, 5) * np.float32(0.05)
    controller, pose, twist, gaps, poses = Mpepc(), np.array(start), np.zeros(2), [], []
    for k in range(round(seconds / 0.1)):
        now = Mover(walker.position + 0.1 * k * walker.velocity, walker.velocity, walker.doubt, walker.radius)
        command = controller.step(pose, twist, np.array(path), clearance, FRAME, movers=[now])
        twist = np.array([command.v, command.omega])
        middle = pose[2] + 0.05 * command.omega
        pose = pose + 0.1 * np.array([command.v * np.cos(middle), command.v * np.sin(middle), command.omega])
        gaps.append(np.hypot(*(now.position + 0.1 * now.velocity - pose[:2])) - 0.43)
        poses.append(pose)
    return min(gaps), np.array(poses), controller


@pytest.mark.parametrize("speed", [0.5, 0.9, 1.2])
@pytest.mark.parametrize("late", [-0.6, 0.0, 0.6])
def test_it_gives_way_to_who_crosses_and_arrives(speed, late):
    crossing = 2.4 + late  # s; alone, the robot is at x = 1.2 after that
    closest, poses, controller = drive(mover((1.2, -speed * crossing), (0.0, speed), 0.15), 12.0)
    assert closest > 0.05 and controller.arrived
    np.testing.assert_allclose(poses[-1, :2], (2.5, 0.0), atol=0.1)


def test_it_backs_out_of_the_way_in_a_passage():
    """A wall on either side, and somebody who comes along the front of the robot, which can only go back."""
    occupied = np.zeros(FRAME.shape, bool)
    y = FRAME.to_world(*np.indices(FRAME.shape))[..., 1]
    x = FRAME.to_world(*np.indices(FRAME.shape))[..., 0]
    occupied[(np.abs(y) > 0.35) & (x < 0.2)] = True
    closest, poses, _ = drive(mover((0.4, -1.6), (0.0, 0.8), 0.15), 3.0, occupied=occupied)
    assert poses[:, 0].min() < -0.1 and closest > 0.0


def test_when_every_way_collides_it_stands_and_does_not_drive_into_them():
    ring = [mover((0.75 * np.cos(a), 0.75 * np.sin(a)), (-0.3 * np.cos(a), -0.3 * np.sin(a))) for a in range(6)]
    free = np.full(FRAME.shape, 3.0, np.float32)
    controller, v = Mpepc(), 0.5
    for _ in range(5):
        v = controller.step(np.zeros(3), (v, 0.0), np.array([[0, 0], [2, 0]]), free, FRAME, movers=ring).v
    assert abs(v) < 0.1
