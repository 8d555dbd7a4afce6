"""``vlpg eval overlay``: an ObjectNav episode as pictures: what the robot sees, believes, and where it wants to go.

FILE ends in .png for one step, or in .gif or .webp for the whole episode, moving.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np

from edge.perception.encoder import Encoder
from firmware_sim.house import HouseError
from firmware_sim.seed import seed
from models.manifest import DEFAULT, ModelError
from tools.eval.judge import instances_of
from tools.eval.objectnav.episode import Run
from tools.eval.objectnav.planners import PLANNERS
from tools.eval.options import check_folder

SIDE = 480  # px, of a map
MARGIN = 0.4  # m of map around what is known
FRAME = 200  # ms a step lasts in an animation
_OCCUPIED, _UNKNOWN = (50, 50, 50), (215, 215, 215)  # BGR
_PATH, _PLAN, _GOAL, _TRUE = (220, 110, 40), (120, 200, 60), (60, 60, 230), (0, 160, 240)


def draw(run: Run, driven: np.ndarray) -> np.ndarray:
    """One step, ``(H, W, 3)`` BGR: the camera's picture and words; mean and standard deviation of the relevance.

    ``driven (N, 2)`` [m] is the path so far, in the robot's map.
    """
    relevance, agent = run.agent.exploration.relevance, run.agent
    maps = []
    for title, values, high in (
        ("relevance, mean", relevance.mean, max(1.0, float(relevance.mean.max(initial=0.0)))),
        ("relevance, deviation", np.sqrt(relevance.variance), float(np.sqrt(relevance.config.variance))),
    ):
        canvas = _map(run, values / high, driven)
        _write(canvas, f"{title}, 0 to {high:.2f}", (10, 20), 0.5)
        maps.append(canvas)
    picture = cv2.cvtColor(run.world.picture.rgb, cv2.COLOR_RGB2BGR)
    column = np.full((SIDE, picture.shape[1] + 20, 3), 255, np.uint8)
    column[10 : 10 + picture.shape[0], 10:-10] = picture
    goal = agent.exploration.goal
    lines = [
        f"{run.noun}: action {agent.actions}",
        agent.ending or ("to what seems to be it" if goal else f"{len(agent.exploration.choice.offered)} frontiers"),
        "provisional" if goal and goal.provisional else "",
    ]
    for number, line in enumerate(lines):
        _write(column, line, (12, picture.shape[0] + 40 + 26 * number), 0.6)
    return np.hstack([column, *maps])


def _map(run: Run, values: np.ndarray, driven: np.ndarray) -> np.ndarray:
    """``values (R, C)`` in [0, 1] on the robot's grid, with frontiers, path, plan and goal: ``(SIDE, SIDE, 3)`` BGR."""
    robot, agent = run.robot, run.agent
    frame = robot.grid.frame
    image = cv2.applyColorMap((255 * np.clip(values, 0, 1)).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    image[robot.grid.unknown], image[robot.grid.occupied] = _UNKNOWN, _OCCUPIED
    rows, cols = np.nonzero(~robot.grid.unknown)
    low = frame.to_world(rows.min(), cols.min()) - MARGIN
    high = frame.to_world(rows.max(), cols.max()) + MARGIN
    scale = SIDE / float((high - low).max())  # px a metre

    def at(places) -> np.ndarray:
        x, y = (np.reshape(places, (-1, 2)) - low).T * scale
        return np.stack([x, SIDE - 1 - y], axis=-1).astype(np.int32)

    zoom = scale * frame.resolution
    corner = (np.array(frame.origin) - low) * scale
    shift = np.array([[zoom, 0, corner[0] + zoom / 2], [0, -zoom, SIDE - 1 - corner[1] - zoom / 2]])
    canvas = cv2.warpAffine(image, shift, (SIDE, SIDE), flags=cv2.INTER_NEAREST, borderValue=_UNKNOWN)
    offered, scores = agent.exploration.choice.offered, agent.exploration.choice.scores
    for frontier, score in zip(offered, scores):
        best = score == scores.max()
        cv2.polylines(canvas, [at(frontier.cells)], False, (255, 255, 255), 2 + 2 * best, cv2.LINE_AA)
        x, y = at(frontier.waypoint)[0].tolist()
        for colour, width in (((0, 0, 0), 3), ((255, 255, 255), 1)):  # light on a dark rim: it lies on any colour
            _write(canvas, f"{score:.2f}", (x + 4, y), 0.4, colour, width)
    cv2.polylines(canvas, [at(driven)], False, _PATH, 2, cv2.LINE_AA)
    if agent.path is not None:
        cv2.polylines(canvas, [at(agent.path)], False, _PLAN, 2, cv2.LINE_AA)
    for thing in instances_of(run.world.house, run.noun):
        cv2.polylines(canvas, [at(run.in_map(thing.footprint))], True, _TRUE, 2, cv2.LINE_AA)
    if agent.exploration.goal is not None:
        x, y = at(agent.exploration.goal.centroid)[0].tolist()
        cv2.drawMarker(canvas, (x, y), _GOAL, cv2.MARKER_TILTED_CROSS, 14, 2)
    here, ahead = at([robot.pose[:2], robot.pose[:2] + 0.4 * np.array([np.cos(robot.pose[2]), np.sin(robot.pose[2])])])
    cv2.circle(canvas, here.tolist(), max(3, round(robot.config.radius * scale)), _PATH, -1, cv2.LINE_AA)
    cv2.line(canvas, here.tolist(), ahead.tolist(), _PATH, 2, cv2.LINE_AA)
    return canvas


def _write(canvas: np.ndarray, text: str, place: tuple[int, int], size: float, colour=(0, 0, 0), width=1) -> None:
    cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, size, colour, width, cv2.LINE_AA)


def main(arguments: list[str] | None = None) -> None:
    """``vlpg eval overlay``."""
    parser = argparse.ArgumentParser(
        prog="vlpg eval overlay", description=__doc__.split(": ", 1)[1], formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("home", help="a name, a file, or generated:SEED")
    parser.add_argument("object", help="the name of a thing in it")
    parser.add_argument("file", type=Path, metavar="FILE")
    parser.add_argument("--planner", choices=list(PLANNERS), default="I-FBE2")
    parser.add_argument("--encoder", default=DEFAULT, metavar="MODEL", help="a model's name, or oracle: true labels")
    parser.add_argument("--step", type=int, metavar="N", help="draw the episode after N actions (default: at its end)")
    parser.add_argument("--seed", type=seed, default=0, help="of every source of noise")
    options = parser.parse_args(arguments)
    if options.step is not None and options.step < 1:
        parser.error("--step must be at least 1")
    moving = options.file.suffix in (".gif", ".webp")
    if not moving and options.file.suffix != ".png":
        parser.error(f"{options.file.name}: end it in .png, .gif or .webp")
    check_folder(parser, options.file)
    try:
        encoder = None if options.encoder == "oracle" else Encoder.load(options.encoder)
        run = Run(options.home, options.object.lower(), PLANNERS[options.planner], encoder, options.seed)
    except (HouseError, ModelError) as error:
        parser.exit(2, f"vlpg eval overlay: {error}\n")
    if not instances_of(run.world.house, run.noun):
        parser.exit(2, f"vlpg eval overlay: there is no {run.noun} in {run.world.house.name}\n")
    frames = play(run, options.step, moving)
    if moving:
        animation = cv2.Animation()
        animation.frames, animation.durations = frames, np.full(len(frames), FRAME, np.int32)
        cv2.imwriteanimation(str(options.file), animation)
    else:
        cv2.imwrite(str(options.file), frames[-1])
    print(f"{run.noun}: {run.agent.ending or 'still searching'} after {run.agent.actions} actions; see {options.file}")


def play(run: Run, steps: int | None, every: bool) -> list[np.ndarray]:
    """Go through an episode, up to so many ``steps``; the pictures of ``every`` step, or the last one alone."""
    driven, frames = [run.robot.pose[:2]], []
    while not run.done and (steps is None or run.agent.actions < steps):
        run.step()
        driven.append(run.robot.pose[:2])
        if every:
            frames.append(draw(run, np.array(driven)))
    return frames or [draw(run, np.array(driven))]


if __name__ == "__main__":
    main()
