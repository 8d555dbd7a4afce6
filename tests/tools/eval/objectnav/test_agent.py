"""An agent's decisions, one by one."""

from tools.eval.objectnav.agent import AgentConfig
from tools.eval.objectnav.episode import Run
from tools.eval.objectnav.planners import PLANNERS


def test_only_what_is_near_is_looked_at_closely(home, monkeypatch):
    run = Run(home, "teddy bear", PLANNERS["closest"], None, 0)
    exploration, robot = run.agent.exploration, run.robot
    look_closely, away = exploration.look_closely, []

    def measured():
        place = exploration.goal.nearest(robot.pose)
        away.append(float(((place - robot.pose[:2]) ** 2).sum() ** 0.5))
        return look_closely()

    monkeypatch.setattr(exploration, "look_closely", measured)
    noticed = 0.0
    while not run.done:
        run.step()
        if exploration.goal is not None and not noticed:
            noticed = float(((exploration.goal.nearest(robot.pose) - robot.pose[:2]) ** 2).sum() ** 0.5)
    assert away and max(away) < AgentConfig.near < noticed
