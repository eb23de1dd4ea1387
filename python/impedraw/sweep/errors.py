"""The error of a wrong specification, argument or data set: one line, for the user."""

import difflib
from collections.abc import Iterable


class SweepError(ValueError):
    """One line that names where, what is wrong, and what would be valid."""


def nearest(name: str, valid: Iterable[str], most: int = 12) -> str:
    """What would be valid in place of `name`: the closest names, else all of them if few."""
    names = sorted(valid)
    close = difflib.get_close_matches(name, names, n=3, cutoff=0.6)
    if close:
        return "did you mean " + " or ".join(close) + "?"
    return "valid are " + ", ".join(names[:most]) + (", …" if len(names) > most else "")
