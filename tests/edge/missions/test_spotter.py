"""A target behind something: looked at from where it shows."""

from dataclasses import replace

import numpy as np

from edge.missions.centring import centre
from edge.missions.mission import Mission
from edge.missions.motion import drive, turn
from edge.missions.spotter import Spotter, SpotterConfig
from edge.observation import STOP
from edge.perception.prompts import Target
from edge.pose import wrap
from tools.eval.child import in_child
from tools.eval.tour import run


class Look(Mission):
    """Drives to where the couch is looked at from, and approaches it."""

    def __init__(self, robot, config):
        self.spotter = Spotter(robot, Target.of("couch", robot.encoder), config)
        super().__init__(robot)

    def story(self):
        yield from drive(self.robot, (0.0, -1.2), heading=1.9)
        seen = yield from self.spotter.look()
        centred = yield from self.spotter.approach(seen)
        return (yield from self.spotter.hidden(centred))


def look_past_a_cupboard(mapped, x, y, config):
    """How much is hidden in the end by the robot's own measure, how much of the couch is truly in view, and replans."""
    mapped.world.house.add_object("occluder", "cupboard", x, y, 0.0)
    mission = Look(mapped.robot, config)
    run(mapped.world, mission)
    return mission.outcome, mapped.world.visible_fraction("couch-1"), len(mission.spotter.replans)


def test_what_is_half_hidden_is_looked_at_from_aside(mapped):
    hidden, visible, replans = in_child(look_past_a_cupboard, mapped, 1.5, 2.05, None)
    assert visible > 0.7 and hidden < SpotterConfig.hidden and replans == 1


def test_without_a_look_from_aside_most_of_it_stays_hidden(mapped):
    hidden, visible, replans = in_child(look_past_a_cupboard, mapped, 1.5, 2.05, SpotterConfig(hidden=1.0))
    assert visible < 0.3 and hidden > SpotterConfig.hidden and replans == 0


def test_what_stands_free_is_looked_at_once(mapped):
    hidden, visible, _ = in_child(look_past_a_cupboard, mapped, 3.3, 2.4, None)
    assert visible > 0.9 and hidden < SpotterConfig.hidden


def look_in_vain_from_aside(mapped):
    """How far [rad] from the couch it looks in the end, if the look from aside is in vain and there is no way back."""
    mission = Look(mapped.robot, None)
    spotter, robot = mission.spotter, mapped.robot
    uncover = spotter.uncover

    def stare():
        yield from turn(robot, 1.0)  # it looks elsewhere, and then
        robot.config = replace(robot.config, radius=5.0)  # no way is wide enough any more

    def uncovering(centred):
        spotter.stare, spotter.centred = stare, centred
        return (yield from uncover(centred))

    spotter.uncover = uncovering
    mapped.world.house.add_object("occluder", "cupboard", 1.5, 2.0, 0.0)
    run(mapped.world, mission)
    x, y = spotter.centred.position - robot.pose[:2]
    return robot.config.radius, float(wrap(np.arctan2(y, x) - robot.pose[2]))


def test_after_a_vain_look_from_aside_it_faces_what_it_found_wherever_the_way_back_ended(mapped):
    radius, off = in_child(look_in_vain_from_aside, mapped)
    assert radius == 5.0 and abs(off) < 0.1


class LookAround(Mission):
    """Looks to all sides from where the couch stands to the left, and centres what it saw best."""

    def story(self):
        robot, sought = self.robot, Target.of("couch", self.robot.encoder)
        spotter = Spotter(robot, sought, SpotterConfig(certain=1.1))  # it is never certain enough to stop there
        yield from drive(robot, (0.0, -1.2), heading=1.2)
        seen = yield from spotter.look()
        off = wrap(seen.pose[2] + seen.bearing - robot.pose[2])
        return off, (yield from centre(robot, spotter.detector, sought, seen))


def look_around(mapped):
    mission = LookAround(mapped.robot)
    run(mapped.world, mission)
    return mission.outcome


def test_after_looking_to_all_sides_it_faces_what_it_saw_and_centres_it(mapped):
    off, centred = in_child(look_around, mapped)
    assert abs(off) < 0.1 and centred is not None


class Waits(Look):
    """Sees the couch, waits longer than centring is patient, and then does not see it for a moment."""

    def story(self):
        yield from drive(self.robot, (0.0, -1.2), heading=1.9)
        detector, sought = self.spotter.detector, Target.of("couch", self.robot.encoder)
        seen, detect, blinks = (yield from self.spotter.look()), detector.detect, 3
        later = self.robot.stamp + 3.0
        while self.robot.stamp < later:
            yield STOP

        def blinking(*what):
            nonlocal blinks
            blinks -= 1
            return detect(*what) if blinks < 0 else None

        detector.detect = blinking
        return (yield from centre(self.robot, detector, sought, seen)) or "lost"


def wait(mapped):
    mission = Waits(mapped.robot, None)
    run(mapped.world, mission)
    return mission.outcome != "lost"


def test_centring_is_as_patient_with_what_was_seen_a_while_ago(mapped):
    assert in_child(wait, mapped)
