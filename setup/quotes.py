"""Fills in figures between markers in Markdown files, and reports stale ones.

    <!-- figure:bowl-sine.ink_error_rms -->0.010<!-- / -->    one number; the old text sets the
                                                              number of decimals
    <!-- figures:table realistic -->                          a whole table
    …
    <!-- /figures -->

A quoted number is stale if it differs by more than one in its last digit.
"""

import math
import pathlib
import re
from typing import Callable

INLINE = re.compile(r"<!-- figure:(?P<id>[^ ]+) -->(?P<text>[^<\n]*)<!-- / -->")
TABLE = re.compile(
    r"(?P<head><!-- figures:table (?P<id>[\w-]+) -->\n)(?P<text>.*?)(?P<tail><!-- /figures -->)",
    re.DOTALL,
)
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def fill_part(page: pathlib.Path, name: str, lines: list[str]) -> None:
    """Writes `lines` between <!-- name --> and <!-- /name --> of a page."""
    head, begin, rest = page.read_text().partition(f"<!-- {name} -->\n")
    _, end, tail = rest.partition(f"<!-- /{name} -->")
    if not begin or not end:
        raise QuoteError(f"{page}: no <!-- {name} --> with its end")
    page.write_text(head + begin + "\n".join(lines) + "\n" + end + tail)


class QuoteError(Exception):
    """A marker that cannot be filled in. Names the file, the line and the fault."""


def decimals(number: str) -> int:
    return len(number.partition(".")[2])


def agrees(a: str, b: str) -> bool:
    """True if two printed numbers differ by at most one in the last decimal that both have."""
    last = min(decimals(a), decimals(b))
    return abs(round(float(a), last) - round(float(b), last)) <= 1.001 * 10.0**-last


def same_but_for_digits(a: str, b: str) -> bool:
    """True if two texts have the same words, and numbers that agree."""
    if NUMBER.split(a) != NUMBER.split(b):
        return False
    return all(agrees(x, y) for x, y in zip(NUMBER.findall(a), NUMBER.findall(b)))


def sized(value: float, digits: int = 2, most_decimals: int = 4) -> str:
    """`value` with that many significant digits."""
    if value == 0:
        return "0"
    before_the_point = math.floor(math.log10(abs(value))) + 1
    return f"{value:.{min(most_decimals, max(0, digits - before_the_point))}f}"


def printed_like(value: float, text: str) -> str:
    """`value` with as many decimals as the number `text`, or two digits if `text` is not a number."""
    text = text.strip()
    if re.fullmatch(r"[-−]?\d+(\.\d+)?", text):
        return f"{value:.{decimals(text)}f}"
    return sized(value)


def line_of(document: str, position: int) -> int:
    return document.count("\n", 0, position) + 1


def wanted(document: str) -> tuple[list[str], list[str]]:
    """The ids of the numbers and of the tables that a document quotes."""
    return [m["id"] for m in INLINE.finditer(document)], [m["id"] for m in TABLE.finditer(document)]


def check_markers(name: str, document: str) -> None:
    """An opening that nothing closes would be passed over in silence."""
    for opening, whole in (("<!-- figure:", INLINE), ("<!-- figures:", TABLE)):
        starts = {m.start() for m in whole.finditer(document)}
        for m in re.finditer(re.escape(opening), document):
            if m.start() not in starts:
                raise QuoteError(
                    f"{name}:{line_of(document, m.start())}: a marker '{opening}…' that is not closed"
                )


def fill(
    name: str, document: str, value: Callable[[str], float], table: Callable[[str], str]
) -> tuple[str, list[str]]:
    """The document with every quote filled in, and what was stale, one line each.

    value(id), table(id): what the program gives; KeyError where they know no such id.
    """
    check_markers(name, document)
    stale = []

    def known(get, m):
        try:
            return get(m["id"])
        except KeyError as error:
            raise QuoteError(
                f"{name}:{line_of(document, m.start())}: no figure '{m['id']}': {error.args[0]}"
            ) from None

    def number(m):
        now = printed_like(known(value, m), m["text"])
        old = m["text"].strip().replace("−", "-")
        fits = (
            re.fullmatch(r"-?\d+(\.\d+)?", old)
            and old.startswith("-") == now.startswith("-")
            and agrees(old.lstrip("-"), now.lstrip("-"))
        )
        if not fits:
            stale.append(
                f"{name}:{line_of(document, m.start())}: {m['id']} is quoted as '{old}', "
                f"the program gives {now}"
            )
        return f"<!-- figure:{m['id']} -->{now}<!-- / -->"

    def whole_table(m):
        new = known(table, m)
        if same_but_for_digits(m["text"], new):
            return m["head"] + new + m["tail"]
        old_lines, new_lines = m["text"].splitlines(), new.splitlines()
        for i in range(max(len(old_lines), len(new_lines))):
            old = old_lines[i] if i < len(old_lines) else ""
            now = new_lines[i] if i < len(new_lines) else ""
            if not same_but_for_digits(old, now):
                stale.append(
                    f"{name}:{line_of(document, m.start()) + 1 + i}: table {m['id']} has\n"
                    f"    {old}\n  the program gives\n    {now}"
                )
        return m["head"] + new + m["tail"]

    document = TABLE.sub(whole_table, document)
    return INLINE.sub(number, document), stale
