"""A seed of random numbers, as people give it on the command line."""

from argparse import ArgumentTypeError


def seed(text: str) -> int:
    """For ``type`` of an argument: a whole number from 0 on, as numpy's generators take no other."""
    if not text.isdecimal():
        raise ArgumentTypeError(f"{text} is no seed; any whole number from 0 on is one")
    return int(text)
