"""Missions over what was recorded."""

from edge.bench.recording import Recording
from edge.bench.replay import Replay
from edge.mapping.occupancy import OccupancyGrid
from edge.memory.store import Vlpg
from edge.perception.encoder import Encoder
from edge.robot import Robot


def test_the_robot_sees_all_of_it_and_is_asked_when_it_was_asked(recording):
    encoder = Encoder.load()
    with Vlpg.open(":memory:", encoder.name, encoder.digest, encoder.dim) as memory:
        robot = Robot(encoder, memory)
        replay = Replay(Recording(recording), robot)
        stamps, asked = [], []
        for _ in replay.run():
            stamps.append(robot.stamp)
            asked.append(list(replay.searches))
        assert stamps == [seen.stamp for seen in Recording(recording)]
        assert asked == [[]] * 4 + [["couch"]] * 2
        assert replay.searches["couch"].hypotheses and len(memory) > 0
        assert OccupancyGrid.from_bytes(memory.load_map()).free.any()
