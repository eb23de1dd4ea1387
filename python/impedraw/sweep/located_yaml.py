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


class _Loader(yaml.SafeLoader):
    """YAML 1.2's numbers and booleans: 1e3 is a number, `on` and `no` are words."""


_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers
            if tag not in ("tag:yaml.org,2002:bool", "tag:yaml.org,2002:float",
                           "tag:yaml.org,2002:int", "tag:yaml.org,2002:timestamp")]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile(r"^(true|false)$"), list("tf"))
_Loader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?[0-9]+$"),
                              list("-+0123456789"))
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?$"), list("-+.0123456789"))


def read_yaml(file: Path) -> Map:
    """The file's mapping. Raises SweepError with the line of a fault."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise SweepError(f"{file}: cannot be read: {reason}") from None
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
