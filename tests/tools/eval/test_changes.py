"""What changes in a home is what is said to have changed, and the robot can still go everywhere."""

import numpy as np
import pytest

from firmware_sim.free_space import FreeSpace
from firmware_sim.home import load_home
from firmware_sim.placement import ROBOT_RADIUS
from tools.eval.changes import FAR, Household


def nouns(house):
    return {thing.model.name.lower(): (thing.x, thing.y) for thing in house.objects.values()}


@pytest.mark.parametrize("seed", [0, 1])
def test_a_home_changes_as_told(seed):
    household = Household(load_home("apartment"), np.random.default_rng(seed))
    before, names = household.house.to_dict(), nouns(household.house)
    arriving = household.newcomers(6)
    changed = household.change(arriving[:3])
    after = nouns(household.house)
    assert [len(group) for group in (household.moved, household.removed, household.added)] == [3, 3, 3]
    assert changed == household.moved | household.removed and not household.moved & household.removed
    assert household.removed == names.keys() - after.keys() and household.added == after.keys() - names.keys()
    for noun, (x, y) in after.items():
        if noun not in household.added:
            away = np.hypot(x - names[noun][0], y - names[noun][1])
            assert away > FAR if noun in household.moved else away == 0
    space = FreeSpace(household.house).reachable_area(ROBOT_RADIUS)
    assert min(space.values()) > 0
    again = household.change(arriving[3:])
    assert len(household.moved) == len(household.removed) == len(household.added) == 6 and not again & changed
    twin = Household(load_home("apartment"), np.random.default_rng(seed))
    twin.change(twin.newcomers(6)[:3])
    assert nouns(twin.house) == after and before != twin.house.to_dict()
