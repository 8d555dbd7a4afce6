"""Where the robot can go in a house: the floor on a fine grid, from the true geometry, for generator and judges."""

import cv2
import numpy as np

from edge.mapping.grid import GridFrame
from firmware_sim.placement import is_obstacle

MARGIN = 0.2  # m of grid around the rooms


class FreeSpace:
    """Distance to the nearest wall or obstacle for every cell of the floor, as the house is at construction."""

    def __init__(self, house, resolution: float = 0.05):
        low, high = house.bounds
        low = low - MARGIN
        cols, rows = np.ceil((high + MARGIN - low) / resolution).astype(int)
        self.frame = GridFrame((float(low[0]), float(low[1])), resolution, (int(rows), int(cols)))
        self._house = house
        floor = np.zeros(self.frame.shape, np.uint8)
        for room in house.rooms:
            self._fill(floor, np.array(room.polygon), 1)
        for body in house.plan.wall_bodies:
            self._fill(floor, body, 0)
        for thing in house.objects.values():
            if is_obstacle(thing):
                self._fill(floor, thing.footprint, 0)
        # Distance [m] to the nearest cell that is taken: exact to about a cell.
        self.clearance = cv2.distanceTransform(floor, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * resolution

    def _fill(self, image, polygon, value):
        """Set the cells whose centre lies inside a polygon, or within half a cell: cv2 draws the border too."""
        corners = (np.asarray(polygon) - self.frame.origin) / self.frame.resolution - 0.5
        cv2.fillPoly(image, [np.round(corners * 16).astype(np.int32)], value, shift=4)

    def walls(self) -> np.ndarray:
        """Cells ``(rows, cols)`` bool of walls and closed doors."""
        image = np.zeros(self.frame.shape, np.uint8)
        for body in self._house.plan.wall_bodies:
            self._fill(image, body, 1)
        return image.view(bool)

    def reachable(self, radius: float, start=None) -> np.ndarray:
        """Cells ``(rows, cols)`` bool that the middle of a disc of ``radius`` [m] can reach from the house's start.

        Or from another ``start (2,)`` [m].
        """
        _, label = cv2.connectedComponents((self.clearance >= radius).astype(np.uint8), connectivity=4)
        row, col = self.frame.to_cell(self._house.start[:2] if start is None else start)
        if label[row, col] == 0:
            return np.zeros(self.frame.shape, bool)
        return label == label[row, col]

    def reachable_area(self, radius: float) -> dict[str, float]:
        """For each room by name, how many square metres of it the middle of the disc can reach."""
        rows, cols = np.nonzero(self.reachable(radius))
        area = {room.name: 0 for room in self._house.rooms}
        image = np.zeros(self.frame.shape, np.uint8)
        for index, room in enumerate(self._house.rooms, 1):
            self._fill(image, np.array(room.polygon), index)
        counts = np.bincount(image[rows, cols], minlength=len(area) + 1)
        return {name: float(counts[index]) * self.frame.resolution**2 for index, name in enumerate(area, 1)}
