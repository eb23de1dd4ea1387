"""The settings of a scenario: names, types and limits, from the JSON schema of the program."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .errors import SweepError
from .located_yaml import read_yaml

# Keys of a case that are no settings but arguments of `impedraw draw`.
DRAW_ARGUMENTS = ("scenario", "svg", "text", "shape", "arguments")


class Settings:
    """Every setting that is no group, by its full name."""

    def __init__(self, schema: Mapping[str, Any]) -> None:
        self.leaves: dict[str, Mapping[str, Any]] = {}
        self._collect(schema, "")

    @classmethod
    def read(cls, file: Path) -> "Settings":
        """Reads what `impedraw settings --json-schema` printed."""
        return cls(json.loads(file.read_text(encoding="utf-8")))

    def _collect(self, node: Mapping[str, Any], name: str) -> None:
        if "properties" in node:
            for key, below in node["properties"].items():
                self._collect(below, f"{name}.{key}" if name else key)
        else:
            self.leaves[name] = node

    def columns(self) -> dict[str, str]:
        """The column type of each setting that is not deprecated."""
        return {name: self.column_type(name) for name, leaf in sorted(self.leaves.items())
                if not leaf.get("deprecated")}

    def defaults(self) -> dict[str, Any]:
        """The default of each setting that is not deprecated."""
        return {name: leaf.get("default") for name, leaf in self.leaves.items()
                if not leaf.get("deprecated")}

    def column_type(self, name: str) -> str:
        """`bool`, `int`, `number`, `numbers` or `text` (also of what is none of the others)."""
        leaf = self.leaves.get(name, {})
        kinds = leaf.get("type")
        kinds = set(kinds if isinstance(kinds, list) else [kinds]) - {"null"}
        if kinds == {"array"} and leaf.get("items", {}).get("type") in ("number", "integer"):
            return "numbers"
        simple = {"boolean": "bool", "integer": "int", "number": "number"}
        return simple[kinds.pop()] if len(kinds) == 1 and kinds <= set(simple) else "text"

    def problem(self, name: str, value: Any) -> str | None:
        """What is wrong with the value in itself, in words; None if nothing is."""
        leaf = self.leaves[name]
        if name.endswith((".file", ".svg")) or leaf.get("anyOf"):
            return None
        if "enum" in leaf:
            valid = leaf["enum"]
            return None if value in valid else "valid are " + ", ".join(map(str, valid))
        kinds = leaf.get("type")
        kinds = kinds if isinstance(kinds, list) else [kinds]
        if not any(_is(value, kind) for kind in kinds):
            return "valid is " + " or ".join(_WORDS.get(kind, str(kind)) for kind in kinds)
        if isinstance(value, (list, tuple)):
            least, most = leaf.get("minItems", 0), leaf.get("maxItems", len(value))
            if not least <= len(value) <= most:
                return f"valid are {least} numbers"
            return next((p for v in value if (p := _range(leaf.get("items", {}), v))), None)
        return _range(leaf, value)


_WORDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false",
          "string": "a text", "array": "a list", "null": "null", "object": "a mapping"}


def _is(value: Any, kind: str) -> bool:
    match kind:
        case "boolean":
            return isinstance(value, bool)
        case "integer":
            return isinstance(value, int) and not isinstance(value, bool)
        case "number":
            return isinstance(value, (int, float)) and not isinstance(value, bool)
        case "string":
            return isinstance(value, str)
        case "array":
            return isinstance(value, (list, tuple))
        case "null":
            return value is None
    return True


def _range(leaf: Mapping[str, Any], value: Any) -> str | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    low, high = leaf.get("minimum"), leaf.get("maximum")
    above, below = leaf.get("exclusiveMinimum"), leaf.get("exclusiveMaximum")
    good = ((low is None or value >= low) and (high is None or value <= high)
            and (above is None or value > above) and (below is None or value < below))
    if good:
        return None
    first = f"more than {above}" if above is not None else f"{low}"
    last = f"less than {below}" if below is not None else f"{high}"
    return f"valid are {first} to {last}"


def flat(scenario: Mapping[str, Any], name: str = "") -> dict[str, Any]:
    """{"control": {"friction": 0.3}} → {"control.friction": 0.3}."""
    found: dict[str, Any] = {}
    for key, value in scenario.items():
        full = f"{name}.{key}" if name else str(key)
        if isinstance(value, Mapping):
            found.update(flat(value, full))
        else:
            found[full] = value
    return found


def resolved(file: Path, defaults: Mapping[str, Any], depth: int = 0) -> dict[str, Any]:
    """Every setting that a scenario has of itself: the defaults, what it extends, its own. Raises
    SweepError."""
    if depth > 20:
        raise SweepError(f"{file}: extends more than 20 scenarios, or itself")
    own = flat(read_yaml(file))
    before = own.pop("extends", None)
    return {**(resolved(file.parent / str(before), defaults, depth + 1) if before else defaults),
            **own}


def text_of(value: Any) -> str:
    """The value as `--set NAME=VALUE` takes it."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "null"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(text_of(v) for v in value) + "]"
    return repr(value)


def plain(value: Any) -> Any:
    """The same value for every way of writing it: 5.0 is 5."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    return value
