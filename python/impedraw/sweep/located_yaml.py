"""Reads YAML and keeps the line of every key and entry, which errors need."""

import math
import re
from pathlib import Path
from typing import Any

import yaml

from .errors import SweepError


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
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise SweepError(f"{file}: cannot be read: {reason}") from None
    return read_text(text, file)


def read_text(text: str, file: Path) -> Map:
    """The mapping of a file's text. Raises SweepError."""
    try:
        node = yaml.compose(text, Loader=_Loader)
        value = _value(node, file, 0) if node is not None else None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f":{mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise SweepError(f"{file}{where}: no valid YAML: {problem}") from None
    if not isinstance(value, Map):
        raise SweepError(f"{file}: a specification is a mapping of keys")
    return value


def _value(node: yaml.Node, file: Path, depth: int) -> Any:
    line = node.start_mark.line + 1
    if depth > 30:
        raise SweepError(f"{file}:{line}: nested more than 30 deep")
    if isinstance(node, yaml.MappingNode):
        mapping = Map()
        mapping.line, mapping.lines = line, {}
        for key_node, value_node in node.value:
            at = key_node.start_mark.line + 1
            if not isinstance(key_node, yaml.ScalarNode):
                raise SweepError(f"{file}:{at}: a key must be a word")
            key = key_node.value
            if key in mapping:
                raise SweepError(f"{file}:{at}: {key} stands twice, first in line "
                                 f"{mapping.lines[key]}")
            mapping.lines[key] = at
            mapping[key] = _value(value_node, file, depth + 1)
        return mapping
    if isinstance(node, yaml.SequenceNode):
        sequence = Sequence(_value(item, file, depth + 1) for item in node.value)
        sequence.line = line
        return sequence
    if node.tag == "tag:yaml.org,2002:int":
        return int(node.value)
    if node.tag == "tag:yaml.org,2002:float":
        number = float(node.value)
        if not math.isfinite(number):
            raise SweepError(f"{file}:{line}: {node.value} is too large")
        return number
    if node.tag == "tag:yaml.org,2002:bool":
        return node.value == "true"
    if node.tag == "tag:yaml.org,2002:null":
        return None
    return node.value
