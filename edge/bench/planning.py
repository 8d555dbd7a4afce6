"""``python -m edge.bench.planning RECORDING``: planning on the map of the recorded home, without pictures."""

import sys
import time
from dataclasses import replace
from pathlib import Path
from random import Random

import cv2
import numpy as np

from edge.bench.recording import Recording
from edge.bench.subject import begin, tell, timed
from edge.mapping.frontiers import frontiers, reachable
from edge.mapping.relevance import RelevanceMap
from edge.memory.store import Vlpg
from edge.missions.exploration import ExplorationConfig
from edge.missions.find_object import FindObjectConfig
from edge.missions.motion import route, steer
from edge.observation import RgbdFrame
from edge.planning.local_search import LocalSearch
from edge.planning.mpepc import Mpepc
from edge.planning.viewpoint import rank_viewpoints
from edge.pose import compose
from edge.robot import Robot

CALLS = 40
PERIOD = 0.1  # s
STEPS = 60  # of control on the way to one place, at most


def surveyed(recording: Recording, robot: Robot) -> RgbdFrame:
    """Map the home with lidar and depth, up to the first question; the last picture."""
    end = recording.questions[0][0] if recording.questions else len(recording)
    frame = None
    for _, observation in zip(range(end), recording):
        robot.perceive(replace(observation, frame=None))
        if observation.frame is not None:
            frame, pose = observation.frame, robot.in_map(observation.frame.odom)
            robot.grid.integrate_depth(pose, frame.depth, robot.camera)
            robot.coverage.integrate(pose, frame.depth, robot.camera, robot.grid)
    return frame


def driven(robot: Robot, goals: np.ndarray) -> list[float]:
    """Times [s] of control steps on the way to ``goals (N, 2)``, as if each command were carried out exactly."""
    times = []
    for goal in goals:
        path, controller = route(robot, goal), Mpepc()
        for _ in range(STEPS if path is not None else 0):
            started = time.perf_counter()
            twist = steer(robot, controller, path)
            times.append(time.perf_counter() - started)
            robot.pose = compose(robot.pose, np.array([twist.v * PERIOD, 0.0, twist.omega * PERIOD]))
            robot.twist = np.array([twist.v, twist.omega])
            if controller.arrived:
                break
    return times


def main() -> None:
    begin()
    cv2.setNumThreads(1)
    robot, rng = Robot(None, Vlpg.open(":memory:", "bench", "0" * 64, 1)), np.random.default_rng(0)
    frame = surveyed(Recording(Path(sys.argv[1])), robot)
    grid, camera, radius = robot.grid, robot.camera, robot.config.radius
    ground = reachable(grid, robot.pose, radius)
    places = grid.frame.to_world(*np.nonzero(ground))
    goals = places[rng.choice(len(places), CALLS)]
    headings = rng.uniform(-np.pi, np.pi, FindObjectConfig.hits)
    hits = np.column_stack([places[rng.choice(len(places), len(headings))], headings])
    scores = np.sort(rng.uniform(0.5, 1.0, len(hits)))[::-1]
    explored = robot.coverage.viewed.view(bool) & ~grid.unknown
    relevance, promise = RelevanceMap(), rng.uniform(0.3, 0.5, 7)

    def look_around(i):
        search = LocalSearch(grid.occupied, grid.free, grid.frame, goals[i], hits, scores, camera)
        search.next_pose(robot.pose, ground, grid.clearance(), grid.frame, Random(i))

    tell(
        {
            "plan a way": timed(lambda i: route(robot, goals[i]), CALLS),
            "rank viewpoints": timed(lambda _: rank_viewpoints(hits, scores, grid.occupied, grid.frame, camera), CALLS),
            "seed a local search, choose a view": timed(look_around, CALLS),
            "find frontiers": timed(
                lambda _: frontiers(grid, robot.pose, radius, ExplorationConfig.min_area, explored), CALLS
            ),
            "update the relevance": timed(
                lambda _: relevance.integrate(robot.in_map(frame.odom), frame.depth, promise, camera, grid), CALLS
            ),
            "control": driven(robot, goals[:10]),
        }
    )


if __name__ == "__main__":
    main()
