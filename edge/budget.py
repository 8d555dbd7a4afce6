"""What of a board's memory and time the robot may take."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """Limits. What a report does not have is not judged."""

    board: float  # MB peak PSS, everything on board
    host: float  # MB peak PSS, text on a host
    ram: float = 1.5  # MB, the memory of 2 000 nodes of one 512-d vector
    disk: float = 2.5  # MB, the same in its file
    step: float = 100.0  # ms, perception and planning in 95 of 100 control steps: one control period
    core: float = 50.0  # % of one core that they take at 10 Hz

    def peak(self, text: bool) -> float:
        """MB peak PSS, with or without a text tower."""
        return self.board if text else self.host


BUDGETS = {
    "pi-zero-2w": Budget(board=170.0, host=130.0),  # 512 MB, of which the system takes half
    "qcs605": Budget(board=256.0, host=200.0),  # 2 GB, the board of [V]
}
SMALLEST = BUDGETS["pi-zero-2w"]  # what the robot is built for
SPARE = 30.0  # MB beyond its peak, as the kernel counts a little otherwise


def allowance(text: bool) -> float:
    """MB that a board must have free for the robot, with or without a text tower, and that its service may take."""
    return SMALLEST.peak(text) + SPARE
