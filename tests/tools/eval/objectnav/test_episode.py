"""Whole episodes in a small home with true eyes, and how they are judged."""

import pytest

from edge.mapping.object_goal import ObjectGoal, Surface
from tools.eval.objectnav import command, overlay
from tools.eval.objectnav.agent import AgentConfig
from tools.eval.objectnav.campaign import Plan, chosen
from tools.eval.objectnav.episode import Run, _cause, _claimed, explore
from tools.eval.objectnav.goal_region import GoalRegion
from tools.eval.objectnav.planners import PLANNERS
from tools.eval.spread import load, run_homes

CHEAP = Plan((("closest", PLANNERS["closest"]),), "oracle")


@pytest.fixture(scope="module")
def found(home):
    return explore(home, "I-FBE2", "teddy bear", PLANNERS["I-FBE2"], None, 0)


def test_a_thing_in_another_room_is_found(found):
    assert found.success and found.ending == "found" and found.cause == "" and found.seen
    assert found.distance <= 1.0 and found.length >= found.shortest - 0.1
    assert found.spl == pytest.approx(found.shortest / max(found.shortest, found.length))
    assert 12 < found.actions < 120 and found.confidence == 0.99


def test_the_same_seed_is_the_same_episode(found, home):
    assert explore(home, "I-FBE2", "teddy bear", PLANNERS["I-FBE2"], None, 0) == found


def test_out_of_actions_is_no_success(home):
    run = Run(home, "teddy bear", PLANNERS["closest"], None, 0)
    run.agent.config = AgentConfig(actions=5)
    while not run.done:
        run.step()
    assert run.agent.ending == "out of actions" and run.agent.actions == 5


@pytest.mark.parametrize(
    ("ending", "thing", "cause", "claimed"),
    [
        ("found", "teddy-1", "stopped short", "Teddy bear"),
        ("found", "couch-1", "false positive", "Couch"),
        ("guessed", "couch-1", "wrong guess", "Couch"),
    ],
)
def test_why_a_claim_is_wrong_depends_on_what_was_meant(home, ending, thing, cause, claimed):
    run = Run(home, "teddy bear", PLANNERS["closest"], None, 0)
    run.agent.ending = ending
    run.agent.aim = ObjectGoal(Surface(run.in_map([run.world.house.objects[thing].footprint.mean(axis=0)]), False))
    assert _cause(run, GoalRegion(run.world.house, "teddy bear")) == cause and _claimed(run) == claimed


@pytest.mark.parametrize(
    ("seen", "bumps", "ending", "cause"),
    [
        (True, 0, "explored", "seen but missed"),
        (False, 0, "explored", "never seen"),
        (False, 0, "out of actions", "timeout"),
        (True, 20, "out of actions", "collision trap"),
    ],
)
def test_why_nothing_was_claimed(home, seen, bumps, ending, cause):
    run = Run(home, "teddy bear", PLANNERS["closest"], None, 0)
    run.agent.ending, run.seen, run.bumps = ending, seen, [0] * bumps
    assert _cause(run, GoalRegion(run.world.house, "teddy bear")) == cause and _claimed(run) == ""


def test_what_is_not_there_is_a_false_claim_or_none(home):
    judged = explore(home, "closest", "submarine", PLANNERS["closest"], None, 0)
    assert not judged.success and judged.spl == 0 and judged.cause in ("never seen", "false positive")
    assert not judged.seen and judged.shortest == float("inf")


def test_things_are_drawn_by_lot_of_those_that_are_far_and_can_be_reached(home):
    from firmware_sim.home import load_home

    house = load_home(home)
    assert set(chosen(house, None)) <= {"armchair", "couch", "dustbin", "teddy bear"}
    assert len(chosen(house, 2)) == 2 and chosen(house, 2) == chosen(house, 2)


def test_a_home_is_run_once_and_then_read(home, tmp_path, monkeypatch):
    (first,) = run_homes([home], CHEAP, 1, tmp_path)
    (file,) = tmp_path.glob("*.json")
    assert load(file, CHEAP) == first
    monkeypatch.setattr(Plan, "run", None)  # would fail if it were asked
    assert list(run_homes([home], CHEAP, 1, tmp_path)) == [first]
    assert not list(tmp_path.glob("*.part"))


def test_the_command_prints_a_table(home, tmp_path, capsys):
    files = [tmp_path / name for name in ("all.json", "all.csv", "all.png")]
    command.main(
        ["--homes", home, "--encoder", "oracle", "--planners", "I-FBE2,closest", "--jobs", "1"]
        + [f"--{kind}={file}" for kind, file in zip(("json", "csv", "picture"), files)]
    )
    printed = capsys.readouterr().out
    assert "I-FBE2 has" in printed and "SPL" in printed and all(file.stat().st_size > 100 for file in files)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--planners", "magic"], "no planner magic"),
        (["--homes", "castle"], "castle"),
        (["--objects", "0"], "at least 1"),
        (["--figure", "qq", "--encoder", "oracle"], "oracle"),
        (["--figure", "qq", "--sweep", "beta"], "not allowed"),
        (["--figure", "qq", "--csv", "a.csv"], "leave out"),
    ],
)
def test_a_mistake_is_told_in_a_sentence(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        command.main([*arguments, "--jobs", "1"])
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_an_episode_is_drawn(home, tmp_path, capsys):
    import cv2

    for name in ("step.png", "all.gif"):
        arguments = [home, "teddy bear", str(tmp_path / name), "--encoder", "oracle", "--step", "3"]
        overlay.main(arguments)
        assert "still searching after 3 actions" in capsys.readouterr().out
    picture = cv2.imread(str(tmp_path / "step.png"))
    assert picture.shape == (480, 1300, 3) and picture.std() > 30
    _, animation = cv2.imreadanimation(str(tmp_path / "all.gif"))
    assert len(animation.frames) == 3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["castle", "couch", "a.png"], "castle"), (["apartment", "submarine", "a.png"], "no submarine"),
     (["apartment", "couch", "a.txt"], "end it in")],
)  # fmt: skip
def test_what_cannot_be_drawn_is_told(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        overlay.main([*arguments, "--encoder", "oracle"])
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_every_planner_sees_the_same_before_it_chooses(home):
    names = ("closest", "I-FBE1", "VLFM")
    runs = [Run(home, "dustbin", PLANNERS[name], None, 0) for name in names]
    for run in runs:
        for _ in range(12):
            run.step()
    first, *others = (
        (
            run.world.truth.tolist(),
            run.agent.robot.grid.to_bytes(),
            run.agent.robot.coverage.viewed.tolist(),
            run.agent.exploration.goal and run.agent.exploration.goal.centroid.tolist(),
        )
        for run in runs
    )
    assert all(other == first for other in others)
