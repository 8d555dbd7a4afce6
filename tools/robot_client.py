"""A robot on the wire, as tools speak to it."""

import threading
from collections.abc import Callable

from edge.link import requests
from edge.link.exchange import NoAnswer, ask

NAME = "robot1"  # key root
PROMPT = 10.0  # s for an answer that takes no driving; the robot answers between two control steps
PATIENT = 1800.0  # s for a search or a tour; the robot's own limits are 5 to 15 minutes of its clock


class RobotClient:
    """The robot process. Every call may raise ``NoAnswer``, or ``RequestError`` with the robot's own words."""

    def __init__(self, session, name: str = NAME):
        self._session, self._name = session, name

    def answers(self) -> bool:
        """Whether it is up."""
        try:
            self._ask("status", requests.Status(), requests.StatusReply, 1.0)
        except NoAnswer:
            return False
        return True

    def status(self) -> requests.StatusReply:
        return self._ask("status", requests.Status(), requests.StatusReply)

    def find(self, words: str, search_unknown: bool = False, explore: bool = False) -> requests.FindReply:
        """Returns when the search has ended, minutes later."""
        return self._ask("find", requests.Find(words, search_unknown, explore), requests.FindReply, PATIENT)

    def tour(self) -> requests.TourReply:
        """Returns when the tour has ended, minutes later."""
        return self._ask("tour", requests.Tour(), requests.TourReply, PATIENT)

    def cancel(self) -> bool:
        """Whether there was something to cancel."""
        return self._ask("cancel", requests.Cancel(), requests.CancelReply).cancelled

    def map(self) -> requests.MapReply:
        return self._ask("map", requests.Map(), requests.MapReply)

    def graph(self) -> requests.GraphReply:
        return self._ask("graph", requests.Graph(), requests.GraphReply)

    def _ask(self, request: str, body, kind, timeout: float = PROMPT):
        return ask(self._session, f"{self._name}/{request}", body, kind, timeout)


class Call:
    """A blocking call in a thread of its own, so that the caller can go on watching."""

    def __init__(self, function: Callable, *arguments):
        self._function, self._arguments = function, arguments
        self._result = self._error = None
        # A daemon: a call that is never answered must not keep the program from ending.
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        return not self._thread.is_alive()

    def wait(self, seconds: float) -> bool:
        """Wait for at most ``seconds``; whether it is done."""
        self._thread.join(seconds)
        return self.done

    def result(self):
        """What the function returned; raises what it raised."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._result

    def _run(self) -> None:
        try:
            self._result = self._function(*self._arguments)
        except Exception as error:  # noqa: BLE001  it is raised again where the result is asked for
            self._error = error
