"""What a camera sees of a map, as a mask."""

import numpy as np

from edge.camera import CameraModel
from edge.mapping.grid import GridFrame
from edge.planning.viewpoint import visible_cells


def field_of_view(occupied: np.ndarray, frame: GridFrame, pose, camera: CameraModel) -> np.ndarray:
    """The cells of ``visible_cells`` as a mask ``(R, C)`` bool."""
    mask = np.zeros(occupied.shape, bool)
    mask.ravel()[visible_cells(occupied, frame, pose, camera)] = True
    return mask
