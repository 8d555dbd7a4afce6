import numpy as np
import pytest

from edge.missions.mission import Mission
from edge.missions.motion import drive, length
from edge.pose import wrap
from tests.edge.missions.conftest import make_robot, make_world
from tools.eval.tour import run


def test_length_is_that_of_all_stretches():
    assert length(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])) == 6.0
    assert length(np.zeros((1, 2))) == 0.0


class Drive(Mission):
    def __init__(self, robot, goal, heading):
        self.goal, self.heading = goal, heading
        super().__init__(robot)

    def story(self):
        return (yield from drive(self.robot, self.goal, self.heading))


@pytest.mark.parametrize("heading", [0.3, -2.8])
def test_a_way_that_leads_away_from_the_final_heading_is_driven_to_its_end(heading):
    world = make_world()
    robot = make_robot(world)
    mission = Drive(robot, np.array([-0.7, -0.2]), heading)
    run(world, mission)
    assert mission.outcome is True
    np.testing.assert_allclose(robot.pose[:2], [-0.7, -0.2], atol=0.12)
    assert abs(wrap(robot.pose[2] - heading)) < 0.1
