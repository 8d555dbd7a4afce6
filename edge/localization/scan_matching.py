"""Scan-to-map matching: where the lidar must have been for its scan to lie on the mapped walls and furniture."""

from dataclasses import dataclass

import numpy as np

from edge.localization.likelihood_field import LikelihoodField
from edge.observation import LaserScan
from edge.pose import transform, wrap


@dataclass(frozen=True)
class MatchConfig:
    """Settings of the matcher."""

    min_range: float = 0.10  # m; nearer returns are the robot itself
    kernel: float = 0.08  # m, scale of the robust kernel: lidar noise (2 cm) and half a cell, three times
    iterations: int = 20  # of Gauss-Newton; converges in 5 to 8
    tolerance: float = 2e-4  # m and rad; a smaller step ends the iteration
    wall_beams: int = 6  # neighbours to each side that a wall's direction is taken from: 0.4 m at 2 m
    wall_gap: float = 0.30  # m; a larger step between neighbours is the edge of something
    wall_flatness: float = 0.02  # variance across by along; a corner has 0.3, a wall at 1 m 0.01
    inlier: float = 0.10  # m, two cells: a return this near to a mapped one fits
    min_points: int = 40  # returns on known ground; fewer cannot tell the pose
    good_score: float = 0.75  # below it, the coarse search is tried as well
    noise: float = 0.02  # m, least standard deviation of a return against the map
    independent: float = 0.15  # share of returns that err independently: neighbours share cells and corners
    search_distance: float = 0.30  # m, half width of the coarse search: odometry error of a few metres
    search_angle: float = np.radians(12.0)  # rad, half width of the coarse search
    search_step: float = np.radians(1.0)  # rad; 5 cm, one cell, at 3 m
    search_points: int = 120  # returns used by the coarse search


@dataclass(frozen=True)
class Match:
    """The best pose found."""

    pose: np.ndarray  # (3,) in the map frame
    covariance: np.ndarray  # (3, 3) m², rad²
    score: float  # share of the returns on known ground that lie on something mapped; 0 when too few are
    known: int  # returns on known ground


def returned(scan: LaserScan, min_range: float) -> np.ndarray:
    """Numbers ``(N,)`` of the beams that returned from ``min_range`` [m] or beyond."""
    ranges = np.asarray(scan.ranges, float)
    with np.errstate(invalid="ignore"):
        return np.flatnonzero((ranges >= min_range) & (ranges < scan.range_max))


def scan_points(scan: LaserScan, min_range: float) -> np.ndarray:
    """Ends of the beams that returned, ``(N, 2)`` [m] in base_link."""
    beams = returned(scan, min_range)
    angles = scan.angle_min + scan.angle_increment * beams
    ranges = np.asarray(scan.ranges, float)[beams]
    return ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def match(field: LikelihoodField, scan: LaserScan, guess: np.ndarray, config: MatchConfig = MatchConfig()) -> Match:
    """Matches ``scan`` with the map near ``guess`` (3,), the base's pose in the map at the scan's stamp.

    Gauss-Newton on the distances to the nearest mapped obstacle with the Geman-McClure kernel; when the result fits
    badly, again from the best pose of a correlative search (Olson 2009) around the guess.
    """
    guess = np.asarray(guess, float)
    points = scan_points(scan, config.min_range)
    if len(points) < config.min_points or field.empty:
        return Match(guess, np.diag([1.0, 1.0, 1.0]), 0.0, 0)
    best = refine(field, points, guess, config)
    if best.score < config.good_score:
        coarse = search(field, points, guess, config.search_distance, config.search_angle, config)
        again = refine(field, points, coarse, config)
        best = max(best, again, key=lambda found: found.score)
    return best


def refine(field: LikelihoodField, points: np.ndarray, guess: np.ndarray, config: MatchConfig) -> Match:
    """Gauss-Newton from ``guess`` (3,) with ``points`` (N, 2) [m] in base_link."""
    normals = walls(points, config)
    pose = guess.copy()
    for _ in range(config.iterations):
        value, jacobian, _ = _linearise(field, points, normals, pose)
        weight = 1.0 / (1.0 + (value / config.kernel) ** 2) ** 2
        weighted = jacobian * weight[:, None]
        # The damping holds directions that no return constrains, such as along a corridor, at the guess.
        step = np.linalg.solve(weighted.T @ jacobian + 1e-3 * np.eye(3), -(weighted.T @ value))
        pose = pose + np.clip(step, -0.1, 0.1)
        if np.abs(step).max() < config.tolerance:
            break
    pose[2] = wrap(pose[2])
    value, jacobian, known = _linearise(field, points, normals, pose)
    count = int(known.sum())
    fits = known & (value < config.inlier)
    score = float(fits.sum() / count) if count >= config.min_points else 0.0
    variance = max(float((value[fits] ** 2).mean()) if fits.any() else np.inf, config.noise**2)
    information = config.independent * (jacobian[fits].T @ jacobian[fits]) / variance
    return Match(pose, np.linalg.inv(information + np.eye(3)), score, count)


def search(
    field: LikelihoodField, points: np.ndarray, centre: np.ndarray, distance: float, angle: float, config: MatchConfig
) -> np.ndarray:
    """Pose (3,) of the best fit on a lattice of one cell and ``config.search_step`` around ``centre`` (3,).

    ``points`` (N, 2) [m] in base_link; ``distance`` [m] and ``angle`` [rad] are the half widths of the search.
    """
    cell = field.frame.resolution
    pad = int(np.ceil(distance / cell))
    fit = np.pad(np.exp(-0.5 * (field.distance / config.kernel) ** 2), pad + 1)
    points = points[:: max(1, len(points) // config.search_points)]
    turns = np.arange(-(angle // config.search_step), angle // config.search_step + 1) * config.search_step
    shifts = np.arange(-pad, pad + 1)
    offsets = (shifts[:, None] * fit.shape[1] + shifts).reshape(-1)
    best, found = -1.0, np.asarray(centre, float)
    for turn in turns:
        pose = np.array([centre[0], centre[1], centre[2] + turn])
        row, col = field.frame.to_cell(transform(pose, points))
        row = np.clip(row, -1, field.frame.shape[0]) + pad + 1
        col = np.clip(col, -1, field.frame.shape[1]) + pad + 1
        total = np.take(fit, (row * fit.shape[1] + col)[:, None] + offsets).sum(axis=0)
        winner = int(total.argmax())
        if total[winner] > best:
            best = float(total[winner])
            row_shift, col_shift = np.divmod(winner, len(shifts))
            found = pose + [shifts[col_shift] * cell, shifts[row_shift] * cell, 0.0]
    return found


def walls(points: np.ndarray, config: MatchConfig) -> np.ndarray:
    """Unit normals (N, 2) of the straight walls that ``points`` (N, 2) [m], in beam order, lie on; 0 off any wall.

    Total least squares over a window of neighbours; corners, legs and edges with a jump in them are no wall.
    """
    half = config.wall_beams
    window = np.concatenate([points[-half:], points, points[:half]])
    sums = np.cumsum(np.column_stack([window, window**2, window[:, 0] * window[:, 1]]), axis=0)
    sums = np.concatenate([np.zeros((1, 5)), sums])
    x, y, xx, yy, xy = ((sums[2 * half + 1 :] - sums[: -2 * half - 1]) / (2 * half + 1)).T
    xx, yy, xy = xx - x * x, yy - y * y, xy - x * y
    # Eigenvalues of the 2x2 covariance in closed form; the normal belongs to the smaller one.
    split = np.hypot(xx - yy, 2 * xy)
    across, along = (xx + yy - split) / 2, (xx + yy + split) / 2
    angle = 0.5 * np.arctan2(2 * xy, xx - yy) + np.pi / 2
    jumps = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(window, axis=0).T) > config.wall_gap)])
    straight = (across < config.wall_flatness * along) & (jumps[2 * half :] == jumps[: -2 * half])
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1) * straight[:, None]


def _linearise(field: LikelihoodField, points: np.ndarray, normals: np.ndarray, pose: np.ndarray):
    """Distances (N,), their Jacobian (N, 3) by the pose, and which points are on known ground (N,).

    On a wall only the slope across it counts: along it, the field's slope is the noise of single cells, which would
    hold a robot in a corridor where it is.
    """
    world = transform(pose, points)
    value, slope, known = field.sample(world)
    turned = transform((0.0, 0.0, pose[2]), normals)
    across = (slope * turned).sum(axis=1)[:, None] * turned
    slope = np.where(normals.any(axis=1)[:, None], across, slope)
    arm = world - pose[:2]
    turning = slope[:, 1] * arm[:, 0] - slope[:, 0] * arm[:, 1]
    return value, np.concatenate([slope, turning[:, None]], axis=1), known
