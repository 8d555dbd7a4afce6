"""Where to stand to look at a place: near it, and with nothing on the map in between."""

from dataclasses import dataclass

import cv2
import numpy as np

from edge.mapping.grid import GridFrame


@dataclass(frozen=True)
class StandpointConfig:
    """What makes a good place to look from."""

    spacing: float = 0.10  # m between the places compared
    slack: float = 0.30  # m; where nothing is near enough, this much beyond the nearest there is
    way_weight: float = 1.0  # per m from the robot, as the crow flies
    whole: float = 1.5  # m; nearer, a level camera 0.88 m high loses the floor, and low things
    whole_weight: float = 2.0  # per m nearer than that
    own: float = 0.30  # m of what the place itself may be hidden by: half of the table it stands on
    hidden_weight: float = 8.0  # per m more than that between the place and what stands in front of it


CONFIG = StandpointConfig()


def standpoint(
    place, robot, near: float, reachable: np.ndarray, occupied: np.ndarray, frame: GridFrame, config=CONFIG
) -> np.ndarray | None:
    """Point ``(2,)`` [m] from which ``place (2,)`` [m] is best seen; None if no ground is ``reachable (R, C)``.

    It lies within ``near`` [m] of the place, or as near as the ground comes. Of these, the one is chosen that is soon
    reached from ``robot (2,)`` and whose line of sight over ``occupied (R, C)`` ends close to the place: objects stand
    on what is occupied, so a line may end at the edge of the table, but not at the wall of the next room.
    """
    place, robot = np.asarray(place, float), np.asarray(robot, float)[:2]
    step = max(1, round(config.spacing / frame.resolution))
    if not reachable[::step, ::step].any():  # a strip of ground may lie between the places compared
        step = 1
    rows, cols = np.nonzero(reachable[::step, ::step])
    stands = frame.to_world(rows * step, cols * step)
    away = np.hypot(*(stands - place).T)
    close = away <= max(near, away.min(initial=np.inf) + config.slack)
    if not close.any():
        return None
    stands, away = stands[close], away[close]
    cost = (
        config.way_weight * np.hypot(*(stands - robot).T)
        + config.whole_weight * np.maximum(config.whole - away, 0.0)
        + config.hidden_weight * np.maximum(away - _sight(stands, place, away, occupied, frame) - config.own, 0.0)
    )
    return stands[cost.argmin()]


def stands_before(
    place, seen_from, near: float, reachable: np.ndarray, occupied: np.ndarray, frame: GridFrame, config=CONFIG
) -> np.ndarray:
    """Ground ``(N, 2)`` [m] within ``near`` [m] of ``place (2,)``, on the side it was seen from; N may be 0.

    Of what is ``reachable (R, C)``; the map may hide only the last bit of the way to the place, which is then taken for
    what that stands on. So a wall at its back is no place to stand behind, even if the room is not known yet; nor is
    what is near only through a wall: no way around it, within ``near`` of the place, leads to where it was seen.
    """
    place, towards = np.asarray(place, float), np.asarray(seen_from, float)[:2] - place
    side = _around(place, towards, near, occupied, frame)
    rows, cols = np.nonzero(reachable if side is None else reachable & side)
    stands = frame.to_world(rows, cols).reshape(-1, 2)
    away = np.hypot(*(stands - place).T)
    close = (away <= near) & ((stands - place) @ towards >= 0.0)
    stands, away = stands[close], away[close]
    if not len(stands):
        return stands
    return stands[_sight(stands, place, away, occupied, frame) >= away - config.own]


def _around(place, towards, near: float, occupied: np.ndarray, frame: GridFrame) -> np.ndarray | None:
    """Cells ``(R, C)`` bool near the place, of one piece with the first free one ``towards`` where it was seen from.

    None when there is no free one near it.
    """
    disc = ~occupied & frame.within(near, place)
    length = max(float(np.hypot(*towards)), frame.resolution)
    line = place + np.arange(0.0, min(near, length), frame.resolution / 2)[:, None] * towards / length
    row, col = frame.to_cell(line)
    inside = frame.contains(row, col)
    free = np.flatnonzero(disc[row[inside], col[inside]])
    if not len(free):
        return None
    _, labels = cv2.connectedComponents(disc.view(np.uint8), connectivity=4)
    return labels == labels[row[inside][free[0]], col[inside][free[0]]]


def _sight(stands, place, away, occupied, frame) -> np.ndarray:
    """Length ``(N,)`` [m] of the free line from each of ``stands (N, 2)`` towards ``place (2,)``, ``away (N,)`` off."""
    reach = float(away.max())
    share = np.arange(0.0, reach, frame.resolution / 2) / max(reach, frame.resolution)
    solid = cv2.dilate(occupied.view(np.uint8), np.ones((3, 3), np.uint8))  # a line that just slips by shows half of it
    row, col = frame.to_cell(stands[:, None] + share[:, None] * (place - stands)[:, None])
    inside = frame.contains(row, col)
    met = np.zeros(row.shape, bool)
    met[inside] = solid[row[inside], col[inside]]
    return np.where(met.any(axis=1), share[met.argmax(axis=1)], 1.0) * away
