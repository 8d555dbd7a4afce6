"""What all looks at a place together say: pictures err, and each errs differently."""

from dataclasses import dataclass, replace

import numpy as np

from edge.missions.sighting import Sighting

SAME = 0.4  # m between two sightings of one thing; its visible side moves with the viewpoint


@dataclass
class Place:
    """Something at one place of the map, seen in one or more pictures."""

    nearest: Sighting  # the one from the least depth
    weight: float = 0.0  # of all sightings; a look from half as far away counts four times
    total: float = 0.0  # their weighted sum of scores
    closely: bool = False  # whether the robot has gone there for a close look

    @property
    def score(self) -> float:
        """In [0, 1], the weighted mean of the sightings' scores."""
        return self.total / self.weight

    @property
    def sighting(self) -> Sighting:
        """The nearest sighting, with the score of all."""
        return replace(self.nearest, detection=replace(self.nearest.detection, score=self.score))


class Evidence:
    """The places seen so far. ``places`` is in the order of discovery."""

    def __init__(self):
        self.places: list[Place] = []

    def add(self, sighting: Sighting) -> Place:
        """Count a sighting for the place that it shows, which it may be the first to show."""
        position = sighting.position
        place = min(self.places, key=lambda place: _apart(place, position), default=None)
        if place is None or _apart(place, position) > SAME:
            place = Place(sighting)
            self.places.append(place)
        weight = 1 / max(sighting.depth, 0.1) ** 2
        place.weight += weight
        place.total += weight * sighting.detection.score
        if sighting.depth < place.nearest.depth:
            place.nearest = sighting
        return place

    def ranked(self, least: float) -> list[Place]:
        """Places that score at least ``least``, best first."""
        return sorted((place for place in self.places if place.score >= least), key=lambda place: -place.score)


def _apart(place: Place, position) -> float:
    return float(np.hypot(*(place.nearest.position - position)))
