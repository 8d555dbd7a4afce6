"""Rate and overshoot of centring: ``python -m tools.bench.approach`` drives up to objects.

From two to three and a half metres away, the object 10 to 30 degrees to one side, the robot looks for it with Grad-CAM
in each control step, centres it and drives up to the standoff, as at the end of a search. Where its first look does not
find the object there is nothing to centre; such objects are counted and left out.

Rate: the time of a whole step, perception and planning, on one thread. Overshoot in heading: once the object's middle,
by the simulator's labels, has been within the tolerance of the picture's middle column, how far it is on the other side
than at first. ``end`` tells how far off the object is at the end. With the shipped encoder both are mostly the box's,
which lies beside the object or on another; with ``--encoder oracle`` (true labels) they are the controller's. Overshoot
in distance: how far the object's near surface (the nearest quarter of its pixels) comes nearer than the standoff.
"""

import argparse
import time
from dataclasses import dataclass

import cv2
import numpy as np

from edge.camera import CameraModel
from edge.missions.centring import centre
from edge.missions.mission import Mission
from edge.missions.sighting import sight
from edge.observation import STOP
from edge.perception.detection import Detector
from edge.perception.encoder import Encoder
from edge.perception.prompts import Target
from edge.planning.centring import CentringConfig
from edge.pose import wrap
from firmware_sim.camera import Camera
from firmware_sim.free_space import FreeSpace
from firmware_sim.home import load_home
from firmware_sim.house import House, HouseError
from firmware_sim.seed import seed
from firmware_sim.world import World
from models.manifest import DEFAULT, ModelError
from tools.bench.options import HANDMADE
from tools.bench.survey import RADIUS, robot_in, survey
from tools.eval.oracle import OracleEncoder
from tools.eval.tour import HIGHEST

AWAY = 2.0, 3.5  # m from the object at first
ASIDE = np.radians([10, 30])  # of the object from the optical axis at first
SEEN = 0.7  # of the object's silhouette in the picture, at least, at first
LEAST = 300  # px that it fills; smaller, there is little to see
TRIES = 40  # places looked at for such a view


class Approach(Mission):
    """Look once, then centre what is seen there; the outcome is whether that ended well."""

    def __init__(self, robot, noun: str):
        self.detector, self.target = Detector(robot.encoder), Target.of(noun, robot.encoder)
        self.centring = False
        super().__init__(robot)

    def story(self):
        yield STOP
        robot = self.robot
        first = sight(robot, self.detector, self.target, robot.look_closely())
        if first is None:
            return False
        self.centring = True
        return (yield from centre(robot, self.detector, self.target, first)) is not None


@dataclass(frozen=True)
class Course:
    """What one approach left behind, one row a control step."""

    centred: bool  # as far as the robot can tell
    times: np.ndarray  # (T,) s of each step of perception and planning
    bearings: np.ndarray  # (T,) rad of the object's middle from the optical axis; NaN where it is out of the picture
    depths: np.ndarray  # (T,) m to its near surface

    def heading_overshoot(self, tolerance: float) -> float:
        """rad; NaN when the object was never in the middle."""
        side = np.sign(self.bearings[0])
        reached = np.flatnonzero(np.abs(self.bearings) <= tolerance)
        return max(0.0, float(np.nanmax(-side * self.bearings[reached[0] :]))) if len(reached) else np.nan

    def distance_overshoot(self, standoff: float) -> float:
        """m; of an object that is nearer than the standoff at first, by how much more it comes nearer."""
        return max(0.0, min(standoff, float(self.depths[0])) - float(np.nanmin(self.depths)))


def start(camera: Camera, space: FreeSpace, object_id: str, rng) -> np.ndarray | None:
    """A pose ``(3,)`` that has the object in view, to one side; None where there is none."""
    thing = camera.house.objects[object_id]
    rows, cols = np.nonzero(space.reachable(RADIUS))
    places = space.frame.to_world(rows, cols)
    away = np.hypot(*(places - (thing.x, thing.y)).T)
    places = places[(away > AWAY[0]) & (away < AWAY[1])]
    for x, y in places[rng.permutation(len(places))[:TRIES]]:
        bearing = np.arctan2(thing.y - y, thing.x - x) + rng.choice([-1, 1]) * rng.uniform(*ASIDE)
        pose = np.array([x, y, wrap(bearing)])
        whole = camera.silhouette(pose, object_id)
        shown = camera.render(pose).instances == camera.object_ids.index(object_id)
        if LEAST < np.count_nonzero(whole) and np.count_nonzero(shown) >= SEEN * np.count_nonzero(whole):
            return pose
    return None


def approach(house: House, grid: bytes, encoder: Encoder | None, object_id: str, pose, seed: int) -> Course | None:
    """Drive up to an object from ``pose (3,)``; None when the first look does not find it. No encoder: the oracle."""
    world = World(house, seed, start=pose)
    robot = robot_in(world, grid, encoder or OracleEncoder(world))
    mission = Approach(robot, house.objects[object_id].model.name.lower())
    observation, rows = world.step(None), []
    while not mission.done:
        begin = time.perf_counter()
        twist = mission.step(observation)
        took = time.perf_counter() - begin
        if mission.centring:
            rows.append((took, *_where(world, object_id)))
        observation = world.step(twist)
    # The first step also took the first look; in the last one there was nothing left to do.
    rows = rows[1:-1]
    if not rows or not np.isfinite(rows[0][1]):
        return None
    return Course(mission.outcome, *np.array(rows).T)


def _where(world: World, object_id: str) -> tuple[float, float]:
    """Bearing [rad] of an object's middle and depth [m] of its near surface in the newest picture; NaN if not in it."""
    if object_id not in world.object_ids:
        return np.nan, np.nan
    shown = world.picture.instances == world.object_ids.index(object_id)
    columns, depths = np.flatnonzero(shown.any(axis=0)), world.picture.depth[shown]
    depths = depths[depths > 0]
    if not len(depths):
        return np.nan, np.nan
    middle = (columns[0] + columns[-1]) / 2
    return float(CameraModel().bearing(middle)), float(np.quantile(depths, 0.25))


def show(courses: list[Course], asked: int, config: CentringConfig) -> None:
    """Print the figures."""
    print(f"{asked} objects, {len(courses)} found at the first look, {sum(c.centred for c in courses)} centred")
    if not courses:
        return
    times = 1e3 * np.concatenate([course.times for course in courses])
    p50, p95 = np.percentile(times, [50, 95])
    late = (times > 100).mean()
    print(f"a step: p50 {p50:.0f} ms, p95 {p95:.0f} ms of {len(times)}: {1e3 / p50:.0f} and {1e3 / p95:.0f} Hz; "
          f"{late:.1%} took more than 100 ms")  # fmt: skip
    headings = np.degrees([course.heading_overshoot(config.angle_tolerance) for course in courses])
    ends = np.degrees([abs(course.bearings[np.isfinite(course.bearings)][-1]) for course in courses])
    nearer = [course.distance_overshoot(config.depth) for course in courses]
    for name, values, unit in (("heading", headings, "°"), ("end", ends, "°"), ("distance", nearer, " m")):
        median, most = np.nanmedian(values), np.nanmax(values)
        print(f"{name:9} median {median:.2f}{unit}, most {most:.2f}{unit}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--homes", nargs="+", default=HANDMADE, help="names, files or generated:SEED")
    parser.add_argument("--objects", type=int, default=8, help="a home, drawn by the seed (default: %(default)s)")
    parser.add_argument("--encoder", default=DEFAULT, metavar="MODEL", help="a model's name, or oracle: true labels")
    parser.add_argument("--seed", type=seed, default=0, help="of the draw and of all noise")
    options = parser.parse_args()
    if options.objects < 1:
        parser.error("--objects must be at least 1")
    cv2.setNumThreads(1)
    try:
        houses = [load_home(home) for home in options.homes]
        encoder = None if options.encoder == "oracle" else Encoder.load(options.encoder)
    except (HouseError, ModelError) as error:
        parser.exit(2, f"tools.bench.approach: {error}\n")
    rng = np.random.default_rng(options.seed)
    courses, asked = [], 0
    for house in houses:
        grid, space, camera = survey(house).to_bytes(), FreeSpace(house), Camera(house, noise=False)
        things = [thing.id for thing in house.objects.values() if thing.elevation < HIGHEST]
        asked_here = 0
        for object_id in rng.permutation(things):
            pose = start(camera, space, object_id, rng)
            if pose is None:
                continue
            asked_here += 1
            course = approach(house, grid, encoder, object_id, pose, options.seed)
            if course is not None:
                courses.append(course)
            if asked_here == options.objects:
                break
        asked += asked_here
    show(courses, asked, CentringConfig())


if __name__ == "__main__":
    main()
