"""The error of a wrong specification, argument or data set: one line, for the user."""

import difflib
from collections.abc import Iterable
from pathlib import Path

# How messages name the program: an installed package has its data beside it.
COMMAND = "impedraw" if (Path(__file__).parents[1] / "data").is_dir() else "./impedraw"
_LONGEST = 600  # characters of a message: what a file holds may be long


class SweepError(ValueError):
    """One line that names where, what is wrong, and what would be valid."""

    def __init__(self, message: str) -> None:
        if len(message) > _LONGEST:
            message = f"{message[: _LONGEST // 2]} … {message[-_LONGEST // 2 :]}"
        super().__init__("".join(c if c.isprintable() else repr(c)[1:-1] for c in message))


def nearest(name: str, valid: Iterable[str], most: int = 12) -> str:
    """What would be valid in place of `name`: the closest names, else all of them if few."""
    names = sorted(valid)
    close = difflib.get_close_matches(name[:100], names, n=3, cutoff=0.6)
    if close:
        return "did you mean " + " or ".join(close) + "?"
    return "valid are " + ", ".join(names[:most]) + (", …" if len(names) > most else "")
