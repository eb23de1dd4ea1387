"""The specification of a sweep: which runs, what to keep of each, when one has failed.

    scenario: scenarios/bowl-sine.yaml       # where every case starts
    set: {drawing.redraw: false}             # settings of every case
    axes:                                    # every combination; the last changes fastest
      path.draw_speed: [0.02, 0.05]
      control.normal_force: {from: 1, to: 20, count: 5, scale: log}
      world.joint_friction: {uniform: [0, 1], count: 20, seed: 3}
      tip: {levels: {soft: {world.tip.stiffness: 1e4}, hard: {world.tip.stiffness: 1e5}}}
      pairs: {zip: {canvas.kind: [bowl, dome], drawing.shape: [sine, circle]}}
    when: path.draw_speed * control.normal_force <= 0.5
    seeds: 5
    accept: {contact: contact_fraction >= 0.98}

docs/sweeps.md describes every key. A case's key is a hash of what it sets; two cases that set the
same are one.
"""

import hashlib
import json
import math
import os
import random
import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .errors import COMMAND, SweepError, nearest
from .expression import Expression
from .located_yaml import LARGEST_INT, Map, Sequence, read_text, read_yaml
from .settings import DRAW_ARGUMENTS, Settings, plain, text_of

_BLOCK_KEYS = {"name", "scenario", "svg", "text", "shape", "arguments", "set", "axes", "seeds",
               "when", "case", "keep"}
_TOP_KEYS = _BLOCK_KEYS | {"about", "blocks", "accept", "limits", "report", "tune"}
_KEEP = {"log": "never", "pictures": "never"}
_KEEP_WHEN = ("never", "failed", "always")
_LIMITS = {"time": 120.0, "memory": 8.0}  # of one run: wall time [s], address space [GB]
_VALUES = {"values", "from", "uniform", "loguniform", "normal", "integers", "choice", "levels",
           "zip"}
_VALUES_MORE = {
    "values": set(), "from": {"to", "count", "step", "scale"}, "uniform": {"count", "seed"},
    "loguniform": {"count", "seed"}, "normal": {"count", "seed"}, "integers": {"count", "seed"},
    "choice": {"count", "seed"}, "levels": set(), "zip": set(),
}
_MOST = 1_000_000  # values of all axes together, and cases of all blocks together
_MOST_TEXT = 5_000_000_000  # characters of all cases together
_NAME = re.compile(r"\w[\w .+-]*")
_DEVICE = re.compile(r"(con|nul|aux|prn|com\d|lpt\d)(\..*)?", re.IGNORECASE)  # of Windows


@dataclass(slots=True)
class Case:
    """One run: arguments of `impedraw draw`, settings, and where it stands on each axis."""

    index: int  # its place in the specification's order
    key: str  # 32 hexadecimal digits: a hash of draw and settings
    name: str
    group: str  # the block's name
    draw: dict[str, Any]  # scenario, svg, text, shape, arguments
    settings: dict[str, Any]  # by full name
    levels: dict[str, str] = field(default_factory=dict)  # the label on each named axis
    keep: dict[str, str] = field(default_factory=dict)  # log, pictures: never, failed or always

    def arguments(self) -> list[str]:
        """What follows `impedraw draw`."""
        words = [str(self.draw["scenario"])] if self.draw.get("scenario") else []
        for name in ("svg", "text", "shape"):
            if self.draw.get(name):
                words += [f"--{name}", str(self.draw[name])]
        words += self.draw.get("arguments", [])
        for name, value in self.settings.items():
            words += ["--set", f"{name}={text_of(value)}"]
        return words

    def command(self) -> str:
        """The command that repeats this run."""
        return shlex.join([COMMAND, "draw", *self.arguments()])


@dataclass(slots=True)
class _Point:
    """One place on an axis."""

    label: str
    set: dict[str, Any]


@dataclass(slots=True)
class _Axis:
    name: str
    points: list[_Point]
    when: Expression | None
    named: bool  # levels or zip: the axis has a column of its own


@dataclass(slots=True)
class _Block:
    name: str
    draw: dict[str, Any]
    set: dict[str, Any]
    axes: list[_Axis]
    when: Expression | None
    case: str
    place: str
    keep: dict[str, str]


@dataclass
class Spec:
    """A checked specification."""

    file: Path
    name: str
    about: str
    blocks: list[_Block]
    accept: dict[str, str]  # name → condition that a run must meet, in this order
    limits: dict[str, float]
    report: dict[str, Any]
    tune: dict[str, Any] | None

    def cases(self) -> Iterator[Case]:
        """Every case once, in order. Raises SweepError where a condition cannot be evaluated."""
        seen: set[bytes] = set()
        index = 0
        for block in self.blocks:
            for settings, draw, levels in _combinations(block):
                key = case_key(draw, settings)
                if (digest := bytes.fromhex(key)) in seen:
                    continue
                seen.add(digest)
                values = {**draw, **settings, **levels}
                name = _named(block, values) or f"{block.name}-{key[:8]}"
                yield Case(index, key, name, block.name, draw, settings, levels, block.keep)
                index += 1

    def axis_names(self) -> list[str]:
        """The named axes, which have columns of their own."""
        return list(dict.fromkeys(a.name for b in self.blocks for a in b.axes if a.named))

    def set_names(self) -> list[str]:
        """Every setting that any case sets."""
        names: dict[str, None] = {}
        for block in self.blocks:
            names.update(dict.fromkeys(block.set))
            for axis in block.axes:
                for point in axis.points:
                    names.update(dict.fromkeys(point.set))
        return [n for n in names if n not in DRAW_ARGUMENTS]

    def digest(self) -> str:
        """Hash of every case, and of what is kept and judged; comments and order of keys apart."""
        hashed = hashlib.sha256()
        for case in self.cases():
            hashed.update(f"{case.key} {case.name} {case.group} {sorted(case.levels.items())} "
                          f"{case.keep}\n".encode())
        hashed.update(json.dumps([list(self.accept.items()), self.limits]).encode())
        return hashed.hexdigest()[:32]


def case_key(draw: Mapping[str, Any], settings: Mapping[str, Any]) -> str:
    """The same for the same run, however it is written."""
    content = [{k: v for k, v in draw.items() if v}, {k: plain(v) for k, v in settings.items()}]
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def load_spec(file: Path | str, root: Path, settings: Settings) -> Spec:
    """Reads and checks a specification. Raises SweepError."""
    file = Path(file)
    return _Reader(file, root, settings).spec(read_yaml(file))


def spec_of(content: Mapping[str, Any], root: Path, settings: Settings) -> Spec:
    """The same from a mapping. Raises SweepError."""
    try:
        text = json.dumps(content)  # is YAML
    except (TypeError, ValueError, RecursionError) as error:
        raise SweepError(f"sweep: {error}; valid are mappings, lists, numbers and texts") from None
    return _Reader(Path("sweep"), root, settings).spec(read_text(text, Path("sweep")))


def _combinations(
    block: _Block,
) -> Iterator[tuple[dict[str, Any], dict[str, Any], dict[str, str]]]:
    def extended(
        depth: int, chosen: dict[str, Any], levels: dict[str, str]
    ) -> Iterator[tuple[dict[str, Any], dict[str, str]]]:
        if depth == len(block.axes):
            yield chosen, levels
            return
        axis = block.axes[depth]
        if axis.when is not None and not _holds(axis.when, {**block.draw, **chosen, **levels},
                                                block.place, f"axes.{axis.name}.when"):
            yield from extended(depth + 1, chosen, levels)
            return
        for point in axis.points:
            more = {**levels, axis.name: point.label} if axis.named else levels
            yield from extended(depth + 1, {**chosen, **point.set}, more)

    for chosen, levels in extended(0, dict(block.set), {}):
        if block.when is not None and not _holds(block.when, {**block.draw, **chosen, **levels},
                                                 block.place, "when"):
            continue
        draw = {**block.draw, **{k: v for k, v in chosen.items() if k in DRAW_ARGUMENTS}}
        yield {k: v for k, v in chosen.items() if k not in DRAW_ARGUMENTS}, draw, levels


def _holds(when: Expression, values: Mapping[str, Any], place: str, key: str) -> bool:
    try:
        return bool(when(values))
    except ValueError as error:
        raise SweepError(f"{place}: {key}: {error}; valid are the settings and axes that this "
                         "block sets") from None


def _named(block: _Block, values: Mapping[str, Any]) -> str | None:
    if not block.case:
        return None
    name, rest = "", block.case
    while (start := rest.find("{")) >= 0:
        end = rest.find("}", start)
        if end < 0:
            break
        word = rest[start + 1 : end]
        if word not in values:
            raise SweepError(f"{block.place}: case: {{{word}}} has no value; valid are "
                             f"{', '.join(sorted(values))}")
        name += rest[:start] + _label(values[word])
        rest = rest[end + 1 :]
        if len(name) > 1000:
            raise SweepError(f"{block.place}: case: a name of more than 1000 characters")
    return name + rest


def _label(value: Any) -> str:
    return text_of(plain(value))


class _Reader:
    def __init__(self, file: Path, root: Path, settings: Settings) -> None:
        self.file, self.root, self.settings = file, root, settings
        self.values_left = self.cases_left = _MOST

    def many(self, at: Map, key: str, count: Any) -> int:
        """The number of values of an axis, before they are made. Raises SweepError."""
        good = isinstance(count, int) and not isinstance(count, bool) and count >= 1
        if not good or count > self.values_left:
            raise self.fail(at, key, f"valid are 1 to {_MOST} values, the other axes' among them")
        self.values_left -= count
        return int(count)

    def fail(self, at: Map | Sequence | int | None, key: str, problem: str) -> SweepError:
        line = at if isinstance(at, int) else None
        if isinstance(at, Map):
            line = at.lines.get(key.rsplit(": ", 1)[-1], at.line)
        elif isinstance(at, Sequence):
            line = at.line
        where = f"{self.file}:{line}" if line else f"{self.file}"
        return SweepError(f"{where}: {key}: {problem}" if key else f"{where}: {problem}")

    def spec(self, top: Map) -> Spec:
        self.known(top, _TOP_KEYS, "")
        name = self.word(top, "name", self.file.stem)
        if not _is_folder_name(name):
            if "name" in top:
                raise self.fail(top, "name", f"'{name}' is no name for a folder; valid are at most "
                                "100 letters, digits and _ - + . within")
            name = "sweep"
        shared = {k: v for k, v in top.items() if k in _BLOCK_KEYS}
        if "blocks" in top:
            if not isinstance(top["blocks"], Sequence) or not top["blocks"]:
                raise self.fail(top, "blocks", "empty; valid is a list of blocks")
            for key in ("axes", "when", "seeds"):
                if key in top:
                    raise self.fail(top, key, "stands beside blocks; valid is in each block")
            blocks = [self.block(b, top, f"{name}-{i + 1}") for i, b in enumerate(top["blocks"])]
        else:
            block = Map(shared)
            block.line, block.lines = top.line, top.lines
            blocks = [self.block(block, None, name)]
        limits = dict(_LIMITS)
        for key, value in self.mapping(top, "limits").items():
            if key not in limits:
                raise self.fail(top["limits"], f"limits: {key}", nearest(key, limits))
            limits[key] = self.positive(top["limits"], key, value, 1e6)
        accept = {}
        for key, text in self.mapping(top, "accept").items():
            accept[key] = self.condition(top["accept"], key, text).text
        report = self.mapping(top, "report")
        self.known(report, {"tables", "maps", "lines", "worst", "metrics"}, "report: ")
        self.shown(report, blocks)
        return Spec(self.file, name, str(top.get("about", "") or ""), blocks, accept, limits,
                    dict(report), self.tune(top))

    def shown(self, report: Map, blocks: list[_Block]) -> None:
        """Checks what the page is to show, so that a wrong name is told before anything is run."""
        keys = {"tables": {"rows", "columns", "metrics"}, "maps": {"x", "y", "metric"},
                "lines": {"x", "by", "metric"}}
        axes = {a.name for b in blocks for a in b.axes} | {"scenario", "svg", "group"}
        for kind, own in keys.items():
            parts = report.get(kind, [])
            if not isinstance(parts, list):
                raise self.fail(report, f"report: {kind}", "valid is a list")
            for part in parts:
                if not isinstance(part, Map):
                    raise self.fail(report, f"report: {kind}", "valid is a list of mappings")
                self.known(part, own | {"block", "title"}, f"report: {kind}: ")
                if not all(_is_texts(v) if k == "metrics" else isinstance(v, str)
                           for k, v in part.items()):
                    raise self.fail(part, f"report: {kind}", "valid are names")
                for key in own - {"metric", "metrics", "by"} | ({"by"} & part.keys()):
                    axis = part.get(key)
                    if axis not in axes and axis not in self.settings.leaves:
                        raise self.fail(part, f"report: {kind}: {key}", f"'{axis}' is no axis; "
                                        + nearest(str(axis), axes))
                if "block" in part and part["block"] not in {b.name for b in blocks}:
                    raise self.fail(part, f"report: {kind}: block", f"no block {part['block']}; "
                                    + nearest(str(part["block"]), [b.name for b in blocks]))
        worst = report.get("worst", Map())
        if not isinstance(worst, Map) or not isinstance(worst.get("metric", ""), str) or not (
                _is_whole(worst.get("count", 10), 1, 10_000)):
            raise self.fail(report, "report: worst", "valid is {metric: NAME, count: N}")
        if not _is_texts(report.get("metrics", Sequence())):
            raise self.fail(report, "report: metrics", "valid is a list of metrics")

    def tune(self, top: Map) -> dict[str, Any] | None:
        if "tune" not in top:
            return None
        tune = self.mapping(top, "tune")
        self.known(tune, {"settings", "objective", "constraints", "trials", "seed", "startup"},
                   "tune: ")
        for needed in ("settings", "objective"):
            if not tune.get(needed):
                raise self.fail(top, "tune", f"no {needed}")
        for key, most in (("trials", 100_000), ("startup", 100_000), ("seed", 2**32 - 1)):
            if not _is_whole(tune.get(key, 1), 1, most):
                raise self.fail(tune, f"tune: {key}", "valid is a whole number above 0, at most "
                                f"{most}")
        self.condition(tune, "objective", tune["objective"])
        space = self.mapping(tune, "settings")
        for key, value in space.items():
            self.setting(space, key)
            if not (isinstance(value, Map) and len(value) == 1
                    and next(iter(value)) in ("uniform", "loguniform", "choice")):
                raise self.fail(space, key, "valid is {uniform: [low, high]}, {loguniform: [low, "
                                "high]} or {choice: [...]}")
            self.draws(value, key)
        for key, text in self.mapping(tune, "constraints").items():
            self.condition(tune["constraints"], key, text)
        return dict(tune)

    def block(self, given: Any, top: Map | None, name: str) -> _Block:
        if not isinstance(given, Map):
            raise self.fail(top, "blocks", "valid is a list of mappings")
        self.known(given, _BLOCK_KEYS, "")
        name = self.word(given, "name", name)
        draw: dict[str, Any] = {}
        constants: dict[str, Any] = {}
        for source in (top, given):
            if source is None:
                continue
            draw.update({k: v for k in DRAW_ARGUMENTS if k in source
                         for v in [self.drawn(source, k, source[k])]})
            for key, value in self.mapping(source, "set").items():
                constants[key] = self.checked(source["set"], key, value)
        if "scenario" in constants:
            draw["scenario"] = constants.pop("scenario")
        axes = [self.axis(self.mapping(given, "axes"), key, value)
                for key, value in self.mapping(given, "axes").items()]
        if "seeds" in given:
            points = [_Point(str(s), {"seed": s}) for s in self.seeds(given, given["seeds"])]
            axes.append(_Axis("seed", points, None, False))
        once: dict[str, str] = {}
        for axis in axes:
            for key in {k for p in axis.points for k in p.set}:
                if key in once:
                    raise self.fail(given, "axes", f"{key} is set by {once[key]} and {axis.name}")
                once[key] = axis.name
        when = self.condition(given, "when", given["when"]) if "when" in given else None
        case = self.word(given, "case", self.word(top, "case", "") if top is not None else "")
        keep = dict(_KEEP)
        for source in (top, given):
            if source is not None:
                keep = self.choices(source, "keep", keep, _KEEP_WHEN)
        block = _Block(name, draw, constants, axes, when, case, f"{self.file}:{given.line}", keep)
        if not draw.get("scenario") and not any("scenario" in p.set for a in axes
                                                for p in a.points):
            raise self.fail(given, "scenario", "missing; valid is a scenario's YAML file")
        total = math.prod(len(a.points) for a in axes)
        if total > self.cases_left:
            raise self.fail(given, "axes", f"{total} cases; valid are at most {_MOST} in all "
                            "blocks")
        self.cases_left -= total
        size = len(str(draw)) + len(str(constants)) + sum(
            max((len(str(p.set)) for p in a.points), default=0) for a in axes)
        if total * size > _MOST_TEXT:
            raise self.fail(given, "axes", f"{total} cases of up to {size} characters; valid are "
                            f"at most {_MOST_TEXT} characters together")
        return block

    def axis(self, axes: Map, name: str, given: Any) -> _Axis:
        when = None
        if isinstance(given, Map) and "when" in given:
            when = self.condition(given, "when", given["when"])
            rest = Map({k: v for k, v in given.items() if k != "when"})
            rest.line, rest.lines = given.line, given.lines
            given = rest
        if isinstance(given, Map) and "levels" in given:
            self.known(given, {"levels"}, f"axes: {name}: ")
            points = []
            self.many(axes, name, max(1, len(self.mapping(given, "levels"))))
            for label, level in self.mapping(given, "levels").items():
                level_set = self.mapping(given["levels"], label)
                points.append(_Point(label, {k: self.checked(level_set, k, v)
                                             for k, v in level_set.items()}))
            if not points:
                raise self.fail(axes, name, "no levels; valid is {levels: {label: {setting: "
                                "value}}}")
            return _Axis(name, points, when, True)
        if isinstance(given, Map) and "zip" in given:
            self.known(given, {"zip"}, f"axes: {name}: ")
            columns = {k: self.values(given["zip"], k, v)
                       for k, v in self.mapping(given, "zip").items()}
            lengths = {k: len(v) for k, v in columns.items()}
            if not columns:
                raise self.fail(axes, name, "zip of nothing; valid are lists of the same length")
            if len(set(lengths.values())) != 1:
                told = ", ".join(f"{k} has {n}" for k, n in lengths.items())
                raise self.fail(axes, name, f"zip of different lengths: {told}")
            points = [_Point(", ".join(map(_label, row)), dict(zip(columns, row)))
                      for row in zip(*columns.values())]
            return _Axis(name, points, when, True)
        return _Axis(name, [_Point(_label(v), {name: v}) for v in self.values(axes, name, given)],
                     when, False)

    def values(self, at: Map, name: str, given: Any) -> list[Any]:
        if isinstance(given, Map):
            try:
                found = self.generated(at, name, given)
            except ArithmeticError:
                raise self.fail(at, name, "its numbers are too far apart") from None
        elif isinstance(given, Sequence):
            found = list(given)
        else:
            raise self.fail(at, name, f"'{given}' is no axis; valid is a list, or a mapping with "
                            f"one of {', '.join(sorted(_VALUES))}")
        if not found:
            raise self.fail(at, name, "no values; valid is a list of at least one")
        if isinstance(given, Sequence) or "values" in given:
            self.many(at, name, len(found))
        if any(isinstance(v, float) and not math.isfinite(v) for v in found):
            raise self.fail(at, name, "its numbers are too far apart")
        return [self.checked(at, name, v) for v in found]

    def generated(self, at: Map, name: str, given: Map) -> list[Any]:
        kinds = [k for k in given if k in _VALUES]
        if len(kinds) != 1:
            raise self.fail(at, name, f"valid is exactly one of {', '.join(sorted(_VALUES))}")
        kind = kinds[0]
        self.known(given, {kind} | _VALUES_MORE[kind], f"axes: {name}: ")
        if kind == "values":
            if not isinstance(given["values"], Sequence):
                raise self.fail(given, f"{name}: values", "valid is a list")
            return list(given["values"])
        if kind == "from":
            return self.range(given, name)
        if kind in ("levels", "zip"):
            raise self.fail(at, name, f"{kind} within zip is not possible")
        low_high = self.draws(given, name)
        count = self.many(given, f"{name}: count", given.get("count"))
        seed = given.get("seed", 1)
        if not isinstance(seed, int):
            raise self.fail(given, f"{name}: seed", "valid is a whole number")
        generator = random.Random(f"{seed}/{name}")  # a text: hashed alike on every machine
        draw = {
            "uniform": lambda: generator.uniform(*low_high),
            "loguniform": lambda: math.exp(generator.uniform(*map(math.log, low_high))),
            "normal": lambda: generator.gauss(*low_high),
            "integers": lambda: generator.randint(*low_high),
            "choice": lambda: generator.choice(low_high),
        }[kind]
        return [_rounded(draw()) for _ in range(count)]

    def draws(self, given: Map, name: str) -> list[Any]:
        kind = next(k for k in given if k in _VALUES)
        values = given[kind]
        if not isinstance(values, Sequence) or not values:
            raise self.fail(given, f"{name}: {kind}", "valid is a list")
        if kind == "choice":
            return list(values)
        words = "[mean, deviation]" if kind == "normal" else "[low, high]"
        good = len(values) == 2 and all(isinstance(v, (int, float)) and not isinstance(v, bool)
                                        for v in values)
        if not good or (kind != "normal" and values[0] > values[1]):
            raise self.fail(given, f"{name}: {kind}", f"valid is {words}")
        if kind == "loguniform" and values[0] <= 0:
            raise self.fail(given, f"{name}: {kind}", "valid are bounds above 0")
        if kind == "integers" and not all(isinstance(v, int) for v in values):
            raise self.fail(given, f"{name}: {kind}", "valid are whole numbers")
        return list(values)

    def range(self, given: Map, name: str) -> list[Any]:
        first, last = given["from"], given.get("to")
        for value in (first, last):
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise self.fail(given, f"{name}: from", "valid is {from: NUMBER, to: NUMBER, "
                                "count: N} or step")
        if ("count" in given) == ("step" in given):
            raise self.fail(given, name, "valid is either count or step")
        if "step" in given:
            step = given["step"]
            if isinstance(step, bool) or not isinstance(step, (int, float)) or step == 0 or (
                    (last - first) / step < 0):
                raise self.fail(given, f"{name}: step", "valid is a step from `from` to `to`")
            count = math.floor((last - first) / step * (1 + 1e-12) + 1e-9) + 1
            self.many(given, f"{name}: step", count)
            return [_rounded(first + i * step) for i in range(count)]
        count = self.many(given, f"{name}: count", given["count"])
        scale = given.get("scale", "linear")
        if scale not in ("linear", "log") or (scale == "log" and min(first, last) <= 0):
            raise self.fail(given, f"{name}: scale", "valid is linear, or log between numbers "
                            "above 0")
        if count == 1:
            return [first]
        shares = [i / (count - 1) for i in range(count)]
        if scale == "log":
            inner = [_rounded(first * (last / first) ** s) for s in shares]
        else:
            inner = [_rounded(first + (last - first) * s) for s in shares]
        return [first, *inner[1:-1], last]

    def seeds(self, block: Map, given: Any) -> list[int]:
        if isinstance(given, int) and not isinstance(given, bool) and given >= 1:
            return list(range(1, self.many(block, "seeds", given) + 1))
        if isinstance(given, Sequence) and given and all(_is_whole(s, 0) for s in given):
            self.many(block, "seeds", len(given))
            return list(given)
        raise self.fail(block, "seeds", "valid is a number of seeds, or a list of seeds")

    def checked(self, at: Map, name: str, value: Any) -> Any:
        """The value, if the setting exists and may have it."""
        if name in DRAW_ARGUMENTS:
            return self.drawn(at, name, value)
        self.setting(at, name)
        if isinstance(value, Map):
            raise self.fail(at, name, "is a mapping; valid is a value")
        value = list(value) if isinstance(value, Sequence) else value
        if problem := self.settings.problem(name, value):
            raise self.fail(at, name, f"{text_of(value)} is not valid; {problem}")
        return value

    def setting(self, at: Map, name: str) -> None:
        if name not in self.settings.leaves:
            raise self.fail(at, name, "no setting; " + nearest(name, self.settings.leaves))

    def drawn(self, at: Map, name: str, value: Any) -> Any:
        if name == "arguments":
            if not isinstance(value, Sequence) or not all(isinstance(v, str) for v in value):
                raise self.fail(at, name, "valid is a list of arguments of `impedraw draw`")
            valid = {"--keep-order", "--no-perception", "--skip-unreachable", "--place", "fixed",
                     "auto"}
            for word in value:
                if word not in valid:
                    raise self.fail(at, name, f"'{word}' is not valid; " + nearest(word, valid))
            return list(value)
        if not isinstance(value, str):
            raise self.fail(at, name, "valid is a text")
        if name in ("scenario", "svg") and value:
            return self.path(at, name, value)
        return value

    def path(self, at: Map, name: str, value: str) -> str:
        """From the root of the tree where it lies in it, so that a data set fits every machine."""
        for folder in (self.root, self.file.parent):
            file = Path(os.path.abspath(folder / value))  # symbolic links stay as they are
            if os.path.isfile(file):  # False too for a name that is too long
                root = Path(os.path.abspath(self.root))
                return str(file.relative_to(root)) if file.is_relative_to(root) else str(file)
        raise self.fail(at, name, f"{value} is no file; valid is a path from {self.root} or from "
                        "the specification's folder")

    def known(self, given: Map, valid: set[str], where: str) -> None:
        for key in given:
            if key not in valid:
                raise self.fail(given, f"{where}{key}", "no such key; " + nearest(key, valid))

    def mapping(self, at: Map, key: str) -> Map:
        value = at.get(key)
        if value is None:
            if key in at:
                raise self.fail(at, key, "empty; valid is a mapping")
            value = Map()
            value.line, value.lines = at.line, {}
        if not isinstance(value, Map):
            raise self.fail(at, key, "valid is a mapping")
        return value

    def choices(self, top: Map, key: str, defaults: dict[str, str],
                valid: tuple[str, ...]) -> dict[str, str]:
        chosen = dict(defaults)
        for name, value in self.mapping(top, key).items():
            if name not in defaults:
                raise self.fail(top[key], f"{key}: {name}", "no such key; "
                                + nearest(name, defaults))
            if value not in valid:
                raise self.fail(top[key], f"{key}: {name}", f"'{value}'; valid are "
                                + ", ".join(valid))
            chosen[name] = value
        return chosen

    def condition(self, at: Map, key: str, text: Any) -> Expression:
        if isinstance(text, bool) or not isinstance(text, (str, int, float)):
            raise self.fail(at, key, "valid is a condition, as in path.draw_speed <= 0.1")
        try:
            return Expression(str(text))
        except ValueError as error:
            raise self.fail(at, key, str(error)) from None

    def positive(self, at: Map, key: str, value: Any, most: float) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value <= most:
            raise self.fail(at, key, f"valid is a number above 0, at most {most:g}")
        return float(value)

    def word(self, at: Map, key: str, default: str) -> str:
        value = at.get(key, default)
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise self.fail(at, key, "valid is a text")
        return str(value)


def _is_whole(value: Any, least: int, most: int = LARGEST_INT) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def _is_folder_name(name: str) -> bool:
    """Of one folder, on any system: it leaves the folder that it is made in by no way."""
    return bool(_NAME.fullmatch(name)) and len(name.encode()) <= 100 and name[-1] not in " ." and (
        not _DEVICE.fullmatch(name))


def _is_texts(value: Any) -> bool:
    return isinstance(value, Sequence) and all(isinstance(v, str) for v in value)


def _rounded(value: Any) -> Any:
    """Twelve digits: the same text on every machine."""
    return float(f"{value:.12g}") if isinstance(value, float) else value


__all__ = ["Case", "Spec", "case_key", "load_spec"]
