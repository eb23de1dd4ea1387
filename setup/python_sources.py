#!/usr/bin/env python3
"""Writes the generated parts of the Python package: python/impedraw/_metrics.py from the metrics' definitions
and python/impedraw/canvases.py from the schema of the settings.

python_sources.py PACKAGE_PATH DOCS_SCHEMA TO [--check]: PACKAGE_PATH: where `import impedraw._impedraw` works.
"""

import importlib
import json
import pathlib
import sys

PYTHON = {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "array": "Sequence[float]"}


def extension(package):
    sys.path.insert(0, str(pathlib.Path(package) / "impedraw"))
    return importlib.import_module("_impedraw")


def metrics_source(definitions):
    lines = [
        '"""The metrics of a run. Written by setup/python_sources.py: change src/metrics/metric_definitions.cc."""',
        "",
        "from __future__ import annotations",
        "",
        "from collections.abc import Iterator, Mapping",
        "",
        "",
        "class Metrics(Mapping[str, float | None]):",
        '    """Numbers of a run, by attribute or by name. None: it could not be computed, and ``reasons`` says why."""',
        "",
        "    def __init__(self, values: Mapping[str, float | None], reasons: Mapping[str, str]) -> None:",
        "        self._values = dict(values)",
        "        self.reasons: dict[str, str] = dict(reasons)",
        "",
        "    def __getitem__(self, name: str) -> float | None:",
        "        return self._values[name]",
        "",
        "    def __iter__(self) -> Iterator[str]:",
        "        return iter(self._values)",
        "",
        "    def __len__(self) -> int:",
        "        return len(self._values)",
        "",
        "    def __repr__(self) -> str:",
        '        return "Metrics(" + ", ".join(f"{k}={v!r}" for k, v in self._values.items()) + ")"',
    ]
    for name, unit, meaning, count in definitions:
        # "the same, …" refers to the metric before.
        if meaning.startswith("the same"):
            meaning = f"{base}{meaning[len('the same'):]}"
        else:
            base = meaning.split(",")[0]
        kind = "int" if count else "float"
        of = "" if unit == "1" else f" [{unit}]"
        value = f'self._values["{name}"]'
        lines += [
            "",
            "    @property",
            f"    def {name}(self) -> {kind} | None:",
            f'        """{meaning[0].upper()}{meaning[1:]}{of}."""',
        ]
        if count:
            lines += [f"        value = {value}", "        return None if value is None else int(value)"]
        else:
            lines += [f"        return {value}"]
    return "\n".join(lines) + "\n"


def resolve(schema, node):
    while "$ref" in node:
        target = schema
        for part in node["$ref"].lstrip("#/").split("/"):
            target = target[part]
        node = {**target, **{k: v for k, v in node.items() if k != "$ref"}}
    return node


def kind_of(node):
    for option in [node, *node.get("anyOf", []), *node.get("oneOf", [])]:
        kinds = option.get("type")
        for kind in [kinds] if isinstance(kinds, str) else kinds or []:
            if kind in PYTHON:
                return PYTHON[kind]
    return "str" if "enum" in node else "float"


def canvases_source(schema):
    canvas = resolve(schema, schema["properties"]["canvas"])["properties"]
    kinds = resolve(schema, canvas["kind"])
    kinds = kinds.get("enum") or next(o["enum"] for o in kinds.get("anyOf", kinds.get("oneOf", [])) if "enum" in o)
    group = {"bowl": "cap", "dome": "cap", "trough": "cylinder"}
    lines = [
        '"""The canvases by name. Written by setup/python_sources.py: change src/experiment/canvas_settings.cc."""',
        "",
        "from __future__ import annotations",
        "",
        "from collections.abc import Sequence",
        "from typing import Any",
        "",
        "from . import _impedraw",
        "from ._settings import assignments",
        "",
        "",
        "class CanvasShape:",
        '    """What a canvas is made from: settings that differ from their default."""',
        "",
        "    def __init__(self, kind: str, group: str, values: dict[str, Any]) -> None:",
        "        self._kind = kind",
        "        self._group = group",
        "        self._values = {k: v for k, v in values.items() if v is not None}",
        "",
        "    def settings(self) -> dict[str, Any]:",
        '        """As a scenario takes them: ``{"canvas.kind": "bowl", "canvas.cap.radius": 0.3}``."""',
        '        placed = ("move", "turn")',
        '        result: dict[str, Any] = {"canvas.kind": self._kind}',
        "        for name, value in self._values.items():",
        '            group = "" if name in placed else f"{self._group}."',
        '            result[f"canvas.{group}{name}"] = value',
        "        return result",
        "",
        "    def canvas(self) -> _impedraw.Canvas:",
        '        """The surface itself, for a world or for closest points."""',
        "        return _impedraw.canvas_of_settings(assignments(self.settings()))",
        "",
        "    def __eq__(self, other: object) -> bool:",
        "        return isinstance(other, CanvasShape) and self.settings() == other.settings()",
        "",
        "    __hash__ = None  # type: ignore[assignment]",
        "",
        "    def __repr__(self) -> str:",
        '        given = ", ".join(f"{k}={v!r}" for k, v in self._values.items())',
        '        return f"{type(self).__name__}({given})"',
    ]
    names = []
    for kind in kinds:
        if group.get(kind, kind) not in canvas:  # seen: it has no shape to be made from
            continue
        name = kind.capitalize()
        names.append(name)
        of = group.get(kind, kind)
        fields = resolve(schema, canvas[of])["properties"]
        fields = {k: resolve(schema, v) for k, v in fields.items()}
        for placed in ("move", "turn"):
            fields[placed] = resolve(schema, canvas[placed])
        lines += ["", "", f"class {name}(CanvasShape):", f'    """The canvas `{kind}`. An argument left out has its default.', ""]
        for field, node in fields.items():
            default = f" Default {node['default']}." if "default" in node else ""
            text = " ".join(node.get("description", "").split())
            lines.append(f"    {field}: {text}{default}")
        lines += ['    """', "", "    def __init__(", "        self,", "        *,"]
        for field, node in fields.items():
            lines.append(f"        {field}: {kind_of(node)} | None = None,")
        lines += ["    ) -> None:", f'        super().__init__("{kind}", "{of}", {{']
        lines += [f'            "{field}": {field},' for field in fields]
        lines += ["        })"]
    lines += ["", "", "__all__ = [", '    "CanvasShape",', *[f'    "{n}",' for n in names], "]"]
    return "\n".join(lines) + "\n"


def main():
    package, schema, to = sys.argv[1:4]
    made = {
        "_metrics.py": metrics_source(extension(package).metric_definitions()),
        "canvases.py": canvases_source(json.loads(pathlib.Path(schema).read_text(encoding="utf-8"))),
    }
    stale = []
    for name, text in made.items():
        file = pathlib.Path(to) / name
        if "--check" in sys.argv:
            if not file.is_file() or file.read_text(encoding="utf-8") != text:
                stale.append(name)
        else:
            file.write_text(text, encoding="utf-8")
    if stale:
        sys.exit(f"stale: {', '.join(stale)}; run python3 setup/python_sources.py {package} {schema} {to}")


if __name__ == "__main__":
    main()
