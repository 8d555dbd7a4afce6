"""What the usual alternative to a pose graph takes: a dense grid of embeddings (VLMaps, Huang et al. 2023)."""

import numpy as np

from edge.mapping.occupancy import OccupancyGrid

CELL = 512 * 4  # bytes: a float32 vector of 512 in every cell of 0.05 m


def nbytes(grid: OccupancyGrid) -> int:
    """Bytes of such a grid of the same home: in each cell that anything is known of, not in the box around them."""
    return int(np.count_nonzero(~grid.unknown)) * CELL
