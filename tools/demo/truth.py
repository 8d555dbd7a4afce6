"""What the simulator knows about the home and the robot in it. Tools may ask; missions must not."""

from types import SimpleNamespace

import numpy as np

from edge.camera import CameraModel
from edge.link import requests
from edge.link.conversions import odometry_from_message
from edge.link.exchange import ask
from edge.link.messages import Odometry
from edge.link.topic import Topic
from firmware_sim.house import House
from tools.robot_client import NAME, PROMPT


class Truth:
    """The simulator's answers, under the names of a World that a judge reads."""

    def __init__(self, session, house: House, name: str = NAME):
        self.house, self.config = house, SimpleNamespace(camera_model=CameraModel())
        self.truth = np.array(house.start, float)  # pose (3,) in the house when last looked
        self._session, self._name = session, name
        self._visible: dict[str, float] = {}
        self._odometry = Topic(session, f"{name}/ground_truth/odom", Odometry)

    def position(self) -> np.ndarray | None:
        """Where the robot is ``(2,)`` [m]; None before the simulator has said so."""
        message = self._odometry.read_latest()
        return None if message is None else odometry_from_message(message)[1][:2]

    def look(self, object_ids) -> None:
        """Learn where the robot is, and how much of these things its camera sees; one question for each."""
        self._visible = {}
        for object_id in object_ids:
            key = f"{self._name}/ground_truth/objects"
            reply = ask(self._session, key, requests.Truth(object_id), requests.TruthReply, PROMPT)
            self.truth = np.array(reply.pose)
            self._visible |= {thing.id: thing.visible for thing in reply.objects}

    def visible_fraction(self, object_id: str) -> float:
        """Share of a thing's silhouette that the camera saw at the last look; KeyError if that did not include it."""
        return self._visible[object_id]
