"""``vlpg find``, ``tour``, ``status`` and ``cancel``: a question to a robot that runs, and its answer in words."""

import argparse
import sys
from contextlib import suppress
from math import degrees
from pathlib import Path

from edge.link.exchange import NoAnswer
from edge.link.requests import FindReply, RequestError
from edge.link.session import LinkError, add_link_arguments, key_root, link_config, open_session
from tools.robot_client import NAME, Call, RobotClient

LOST = "lost: it does not find its place in its map"
GUESSES = 3  # told when the object is not in memory
INTERRUPTED = 130  # exit code
SUMMARIES = {
    "find": "Ask the robot to find something; Ctrl-C calls it off. Exit code 0: found, 1: not found.",
    "tour": "Let the robot look at its whole home again, so that it learns what has changed. It takes minutes; Ctrl-C "
    "calls it off. Exit code 0: it has seen all, 1: it was cut short.",
    "status": "What the robot is doing, where it is, and how it fares.",
    "cancel": "Stop what the robot is doing: a search, or a tour of its home.",
}


class AskError(ValueError):
    """A question that makes no sense, or an answer that cannot be kept; the message says why."""


def find(robot: RobotClient, words: str, search: bool, explore: bool, picture: Path | None) -> bool:
    """Ask, wait, and tell; whether it was found. An interrupt cancels the search and goes on up."""
    reply = _answered(robot, Call(robot.find, words, search, explore))
    for line in told(reply):
        print(line)
    if picture is not None:
        keep(reply, picture)
    return reply.status == "found"


def tour(robot: RobotClient) -> bool:
    """Let it look at everything again; whether it got everywhere. An interrupt ends the tour and goes on up."""
    reply = _answered(robot, Call(robot.tour))
    ends = {
        "complete": "seen all",
        "timeout": "out of time before all was seen",
        "lost": LOST,
        "cancelled": "cancelled",
    }
    spent = f"{reply.duration:.1f} s and {reply.distance:.1f} m"
    print(f"{ends[reply.status]}, after {spent}; {reply.nodes} nodes remember the home")
    return reply.status == "complete"


def _answered(robot: RobotClient, call: Call):
    """The reply; an interrupt meanwhile calls off what the robot does, and goes on up."""
    try:
        while not call.wait(0.2):
            pass
    except KeyboardInterrupt:
        with suppress(NoAnswer, RequestError):  # it may be gone, or have ended just now
            robot.cancel()
        raise
    return call.result()


def told(reply: FindReply) -> list[str]:
    """The answer, a line each."""
    spent = f"{reply.duration:.1f} s and {reply.distance:.1f} m"
    if reply.status == "found":
        sure = f", {100 * reply.confidence:.0f} % sure" if reply.confidence is not None else ""
        if reply.position is None:
            return [f"a guess: {reply.object} may be in view of the robot now{sure}, after {spent}"]
        x, y = reply.position
        return [f"found {reply.object} at ({x:.2f}, {y:.2f}) m in the robot's map{sure}, after {spent}"]
    if reply.status == "lost":
        return [f"{LOST}, after {spent}"]
    if reply.status != "not in memory":
        lines = [f"{reply.status}: {reply.object}, after {spent}"]
        if reply.position is not None:
            x, y = reply.position
            lines.append(f"  what resembles it most is at ({x:.2f}, {y:.2f}) m, {100 * reply.confidence:.0f} % sure")
        return lines
    lines = [f"not in memory: {reply.object}"]
    for guess in reply.hypotheses[:GUESSES]:
        x, y, theta = guess.pose
        lines.append(f"  a guess, {guess.score:.2f}: from ({x:.2f}, {y:.2f}) m, looking {degrees(theta):.0f}°")
    return [*lines, "  add --search to look there all the same"] if reply.hypotheses else lines


def keep(reply: FindReply, path: Path) -> None:
    """Write the last picture, with its box, to a file. Raises AskError when there is none or it cannot be written."""
    import cv2
    import numpy as np

    if reply.jpeg is None:
        raise AskError("the robot has no picture to give")
    image = cv2.imdecode(np.frombuffer(reply.jpeg, np.uint8), cv2.IMREAD_COLOR)
    if reply.box is not None:
        x0, y0, x1, y1 = (round(value) for value in reply.box)
        cv2.rectangle(image, (x0, y0), (x1, y1), (10, 214, 255), 2)
    try:
        encoded = cv2.imencode(path.suffix or ".jpg", image)[1]
        path.write_bytes(encoded.tobytes())
    except (cv2.error, OSError) as error:
        raise AskError(f"cannot write {path}: {getattr(error, 'strerror', None) or 'use .jpg or .png'}") from None


def status(robot: RobotClient) -> None:
    """Print how the robot is, a line for each thing."""
    reply = robot.status()
    x, y, theta = reply.pose
    doing = f"finding {reply.object}" if reply.object else reply.state
    lines = {
        "doing": f"{doing}{f', before that: {reply.outcome}' if reply.outcome else ''}",
        "pose": f"({x:.2f}, {y:.2f}) m, {degrees(theta):.0f}° in its map, {reply.distance:.1f} m driven",
        "home": f"{reply.viewed:.1f} of {reply.area:.1f} m² of free floor seen, {reply.nodes} nodes"
        f"{'' if reply.mapped else ', not mapped to the end yet'}",
        "encoder": f"{reply.encoder}, offload {reply.offload}, {'a' if reply.host_alive else 'no'} host is there",
        "memory": f"{reply.memory:.0f} MB PSS, peak {reply.peak_memory:.0f} MB",
        "step": f"{1000 * reply.step_time:.0f} ms in the median, {reply.late} too late",
    }
    if reply.problem:
        lines["problem"] = reply.problem
    for name, text in lines.items():
        print(f"{name:8} {text}")


def cancel(robot: RobotClient) -> None:
    """Stop what the robot is doing."""
    print("cancelled" if robot.cancel() else "there was nothing to cancel")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="vlpg")
    questions = parser.add_subparsers(dest="question", required=True)
    for name, summary in SUMMARIES.items():
        question = questions.add_parser(name, description=summary)
        question.add_argument(
            "--name", type=key_root, default=NAME, help="key root of the robot (default: %(default)s)"
        )
        add_link_arguments(question)
    find = questions.choices["find"]
    find.add_argument("words", nargs="+", metavar="OBJECT", help='what to find, such as "the teddy bear"')
    where = find.add_mutually_exclusive_group()
    where.add_argument("--search", action="store_true", help="look at guesses too; answer with the best")
    where.add_argument("--explore", action="store_true", help="do not ask the memory; explore, as in a home never seen")
    find.add_argument("--picture", type=Path, metavar="FILE", help="write the robot's last picture, with its box")
    return parser


def main(arguments: list[str] | None = None) -> None:
    """Ends with an exit code."""
    options = _parser().parse_args(arguments)
    try:
        words = " ".join(options.words).strip() if options.question == "find" else ""
        if options.question == "find" and not words:
            raise AskError('say what to find, for example: vlpg find "the teddy bear"')
        if options.question == "find" and options.picture and not options.picture.parent.is_dir():
            raise AskError(f"there is no folder {options.picture.parent} to write {options.picture.name} into")
        with open_session(link_config(options)) as session:
            robot = RobotClient(session, options.name)
            if options.question == "find":
                done = find(robot, words, options.search, options.explore, options.picture)
            else:
                done = {"tour": tour, "status": status, "cancel": cancel}[options.question](robot)
    except UnicodeEncodeError:
        print("vlpg find: write the object's name in the terminal's own encoding, UTF-8 as a rule", file=sys.stderr)
        sys.exit(2)
    except (AskError, LinkError, NoAnswer, RequestError) as error:
        print(f"vlpg {options.question}: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    sys.exit(done is False)


if __name__ == "__main__":
    main()
