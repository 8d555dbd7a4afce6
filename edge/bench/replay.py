"""A robot lives through a recording: it maps the home, then looks for what it was asked for, whatever it is shown."""

from collections.abc import Iterator

from edge.bench.recording import Recording
from edge.missions.find_object import FindObject
from edge.missions.map_home import MapHome
from edge.missions.mission import Mission
from edge.observation import Observation, Twist
from edge.perception.prompts import Target
from edge.robot import Robot


class Replay:
    """Missions of ``robot`` over ``recording``. What it commands has no effect: the base goes as it was recorded."""

    def __init__(self, recording: Recording, robot: Robot):
        self.recording, self.robot = recording, robot
        self.searches: dict[str, FindObject] = {}  # by object
        self._mission: Mission = MapHome(robot)

    def run(self) -> Iterator[Twist]:
        """Live through it; the command of each step."""
        questions = dict(self.recording.questions)
        for number, observation in enumerate(self.recording):
            if number in questions:
                self.ask(questions[number])
            yield self.step(observation)

    def ask(self, name: str) -> None:
        """From now on, look for the object; as in the robot process, the map is saved when the mission before ends."""
        self.robot.memory.save_map(self.robot.grid.to_bytes())
        self._mission = FindObject(self.robot, Target.of(name, self.robot.encoder), search_unknown=True)
        self.searches[name] = self._mission

    def step(self, observation: Observation) -> Twist:
        """One control step."""
        return self._mission.step(observation)
