import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from edge.mapping.rays import draw_rays, fill_fan

SIZE = 40
coordinate = st.floats(0.6, SIZE - 0.6)


def crossed(start, end, slack=1e-6):
    """Cells that the segment crosses (supercover), each tested against the segment by Liang-Barsky clipping."""
    cells = np.zeros((SIZE, SIZE), bool)
    delta = end - start
    for row in range(SIZE):
        for col in range(SIZE):
            enter, leave = 0.0, 1.0
            for axis, low in ((0, col - slack), (1, row - slack)):
                high = low + 1 + 2 * slack
                if abs(delta[axis]) < 1e-12:
                    if not low <= start[axis] <= high:
                        leave = -1.0
                    continue
                a, b = sorted(((low - start[axis]) / delta[axis], (high - start[axis]) / delta[axis]))
                enter, leave = max(enter, a), min(leave, b)
            cells[row, col] = enter <= leave
    return cells


@settings(max_examples=40, deadline=None)
@given(coordinate, coordinate, coordinate, coordinate)
def test_a_ray_is_an_unbroken_part_of_the_supercover(x0, y0, x1, y1):
    start, end = np.array([x0, y0]), np.array([x1, y1])
    mask = np.zeros((SIZE, SIZE), np.uint8)
    draw_rays(mask, start, end[None])
    first, last = np.floor(start) + 0.5, np.floor(end) + 0.5
    assert not (mask.astype(bool) & ~crossed(first, last)).any()
    assert mask[int(y0), int(x0)] and mask[int(y1), int(x1)]
    steps = np.abs(np.floor(end) - np.floor(start)).max()
    assert mask.sum() == steps + 1  # one cell for each step along the longer axis
    rows, cols = np.nonzero(mask)
    longer = cols if np.ptp(cols) >= np.ptp(rows) else rows
    assert np.ptp(longer) + 1 == len(np.unique(longer))


def test_many_rays_are_the_union_of_each():
    rng = np.random.default_rng(0)
    ends = rng.uniform(1, SIZE - 1, (50, 2))
    together, union = np.zeros((SIZE, SIZE), np.uint8), np.zeros((SIZE, SIZE), np.uint8)
    draw_rays(together, np.array([20.3, 11.8]), ends)
    for end in ends:
        draw_rays(union, np.array([20.3, 11.8]), end[None])
    assert (together == union).all() and together.max() == 1


def test_no_rays_draw_nothing():
    mask = np.zeros((3, 3), np.uint8)
    draw_rays(mask, np.zeros((0, 2)), np.zeros((0, 2)))
    assert not mask.any()


def test_a_fan_reaches_as_far_as_the_shorter_of_two_neighbours():
    angles = np.linspace(-np.pi, np.pi, 90, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    lengths = np.where(np.arange(90) % 30 == 0, 6.0, 16.0)
    apex = np.array([20.0, 20.0])
    mask = np.zeros((SIZE, SIZE), np.uint8)
    fill_fan(mask, apex, directions, lengths)
    rows, cols = np.nonzero(np.ones_like(mask))
    offset = np.stack([cols + 0.5, rows + 0.5], axis=-1) - apex
    sector = np.floor((np.arctan2(offset[:, 1], offset[:, 0]) + np.pi) / (2 * np.pi / 90)).astype(int) % 90
    limit = np.minimum(lengths[sector], np.roll(lengths, -1)[sector])
    distance = np.hypot(*offset.T)
    inside = mask[rows, cols].astype(bool)
    # Away from the border of its sector a cell's fate is certain; the border itself may fall to either side.
    width = distance * np.pi / 90
    middle = np.abs((np.arctan2(offset[:, 1], offset[:, 0]) + np.pi) % (2 * np.pi / 90) - np.pi / 90) * distance
    sure = middle < width - 1.0
    assert inside[distance < 5.0].all()
    assert not inside[sure & (distance > limit + 1.0)].any()
    assert not inside[distance > 17.0].any()
    assert inside[(distance < limit - 1.0) & sure].all()
