"""Reads YAML and keeps the line of every key and entry, which errors need.

A file need not be trusted: its size, its depth, what its aliases grow to, and the length of each
text and number have bounds. No tag but those of plain values has a meaning.
"""

import itertools
import os
import re
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from .errors import SweepError


LARGEST_FILE = 500_000  # bytes
MOST_VALUES = 200_000  # keys and entries, each as often as aliases repeat it
LONGEST_TEXT = 10_000  # characters of a value
DEEPEST = 30
LARGEST_INT = 2**63 - 1


class Map(dict[str, Any]):
    """A mapping that knows the line of each key."""

    line: int
    lines: dict[str, int]


class Sequence(list[Any]):
    """A list that knows its line."""

    line: int


def _with_yaml_1_2(loader: type) -> type:
    """Of the loader's kind, with YAML 1.2's numbers and booleans: 1e3 is a number, `on` a word."""
    made = type("Loader", (loader,), {})
    left = ("bool", "float", "int", "timestamp")
    made.yaml_implicit_resolvers = {
        first: [(tag, pattern) for tag, pattern in resolvers
                if tag.rsplit(":", 1)[-1] not in left]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }
    for tag, pattern, first in (
        ("bool", r"^(true|false)$", "tf"),
        ("int", r"^[-+]?[0-9]+$", "-+0123456789"),
        ("float", r"^[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?$", "-+.0123456789"),
    ):
        made.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(pattern), list(first))
    return made


_Loader = _with_yaml_1_2(yaml.SafeLoader)
_FastLoader = _with_yaml_1_2(getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def read_scenario(file: Path) -> dict[str, Any]:
    """A scenario's mapping, without lines, in C. Raises OSError, ValueError."""
    with open(file, encoding="utf-8") as text:
        try:
            return yaml.load(text, Loader=_FastLoader) or {}
        except yaml.YAMLError as error:
            raise ValueError(f"{file}: {error}".splitlines()[0]) from None


def read_yaml(file: Path) -> Map:
    """The file's mapping. Raises SweepError with the line of a fault."""
    try:
        # O_NONBLOCK: a pipe that nobody writes to is told, not waited for.
        with open(os.open(file, os.O_RDONLY | os.O_NONBLOCK), "rb") as stream:
            if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                raise SweepError(f"{file}: cannot be read: no regular file")
            content = stream.read(LARGEST_FILE + 1)
        if len(content) > LARGEST_FILE:
            raise SweepError(f"{file}: is larger than {LARGEST_FILE} bytes, which no specification "
                             "is")
        return read_text(content.decode("utf-8"), file)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise SweepError(f"{file}: cannot be read: {reason}") from None


def read_text(text: str, file: Path) -> Map:
    """The mapping of a file's text. Raises SweepError."""
    try:
        node = yaml.compose(text, Loader=_Loader)
        value = _value(node, file, 0, itertools.count(1)) if node is not None else None
    except RecursionError:
        raise SweepError(f"{file}: nested more than {DEEPEST} deep") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f":{mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise SweepError(f"{file}{where}: no valid YAML: {problem}") from None
    if not isinstance(value, Map):
        raise SweepError(f"{file}: a specification is a mapping of keys")
    return value


def _value(node: yaml.Node, file: Path, depth: int, counted: Iterator[int]) -> Any:
    line = node.start_mark.line + 1
    if depth > DEEPEST:
        raise SweepError(f"{file}:{line}: nested more than {DEEPEST} deep")
    if next(counted) > MOST_VALUES:
        raise SweepError(f"{file}:{line}: more than {MOST_VALUES} values, as its aliases repeat "
                         "them")
    kind = node.tag.removeprefix("tag:yaml.org,2002:")
    if kind not in ("map", "seq", "str", "int", "float", "bool", "null"):
        raise SweepError(f"{file}:{line}: {node.tag} is no kind of value here; valid are numbers, "
                         "texts, true, false, null, lists and mappings")
    if isinstance(node, yaml.MappingNode):
        mapping = Map()
        mapping.line, mapping.lines = line, {}
        for key_node, value_node in node.value:
            at = key_node.start_mark.line + 1
            if not isinstance(key_node, yaml.ScalarNode):
                raise SweepError(f"{file}:{at}: a key must be a word")
            key = _text(key_node, file, at)
            if key in mapping:
                raise SweepError(f"{file}:{at}: {key} stands twice, first in line "
                                 f"{mapping.lines[key]}")
            mapping.lines[key] = at
            mapping[key] = _value(value_node, file, depth + 1, counted)
        return mapping
    if isinstance(node, yaml.SequenceNode):
        sequence = Sequence(_value(item, file, depth + 1, counted) for item in node.value)
        sequence.line = line
        return sequence
    text = _text(node, file, line)
    if kind in ("int", "float"):
        try:
            number = float(text) if kind == "float" or len(text) > 20 else int(text)
        except ValueError:
            raise SweepError(f"{file}:{line}: {text} is no number") from None
        if not abs(number) <= (LARGEST_INT if kind == "int" else sys.float_info.max):
            raise SweepError(f"{file}:{line}: {text} is too large")
        return number
    if kind == "bool":
        return text == "true"
    if kind == "null":
        return None
    return text


def _text(node: yaml.ScalarNode, file: Path, line: int) -> str:
    """What stands there. Names and arguments of programs hold no NUL."""
    text: str = node.value
    if len(text) > LONGEST_TEXT:
        raise SweepError(f"{file}:{line}: a text of {len(text)} characters; valid are at most "
                         f"{LONGEST_TEXT}")
    if "\0" in text or any("\ud800" <= c <= "\udfff" for c in text):
        raise SweepError(f"{file}:{line}: a text with a character that is none, as NUL")
    return text
