"""Work done in a copy of this process: it starts from this one's state, and leaves that state alone."""

import multiprocessing


def in_child(function, *arguments):
    """The result of ``function(*arguments)``, computed in a forked child that ends with it.

    A mapped home with its robot, encoder and simulator is costly to make and hard to copy; a fork copies it in
    milliseconds. Raises what the function raised, and RuntimeError when the child died.
    """
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_answer, args=(sender, function, arguments))
    child.start()
    sender.close()
    try:
        result, error = receiver.recv()
    except EOFError:
        child.join()
        raise RuntimeError(f"the process that should answer died with exit code {child.exitcode}") from None
    child.join()
    if error is not None:
        raise error
    return result


def _answer(sender, function, arguments) -> None:
    try:
        answer = function(*arguments), None
    except Exception as error:  # noqa: BLE001 - it goes to the parent, which raises it
        answer = None, error
    sender.send(answer)
