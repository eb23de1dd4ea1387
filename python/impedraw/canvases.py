"""The canvases by name. Written by setup/python_sources.py: change src/experiment/canvas_settings.cc."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from . import _impedraw
from ._settings import assignments


class CanvasShape:
    """What a canvas is made from: settings that differ from their default."""

    def __init__(self, kind: str, group: str, values: dict[str, Any]) -> None:
        self._kind = kind
        self._group = group
        self._values = {k: v for k, v in values.items() if v is not None}

    def settings(self) -> dict[str, Any]:
        """As a scenario takes them: ``{"canvas.kind": "bowl", "canvas.cap.radius": 0.3}``."""
        placed = ("move", "turn")
        result: dict[str, Any] = {"canvas.kind": self._kind}
        for name, value in self._values.items():
            group = "" if name in placed else f"{self._group}."
            result[f"canvas.{group}{name}"] = value
        return result

    def canvas(self) -> _impedraw.Canvas:
        """The surface itself, for a world or for closest points."""
        return _impedraw.canvas_of_settings(assignments(self.settings()))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CanvasShape) and self.settings() == other.settings()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        given = ", ".join(f"{k}={v!r}" for k, v in self._values.items())
        return f"{type(self).__name__}({given})"


class Bowl(CanvasShape):
    """The canvas `bowl`. An argument left out has its default.

    radius: Radius of the sphere. [m] Default 0.3.
    centre: Centre of the sphere. [m] Default [0.6, 0, 0.4].
    opening_radius: Radius of the circle at which the cap ends: radius × sin(slope there). [m] Default 0.18.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        radius: float | None = None,
        centre: Sequence[float] | None = None,
        opening_radius: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("bowl", "cap", {
            "radius": radius,
            "centre": centre,
            "opening_radius": opening_radius,
            "move": move,
            "turn": turn,
        })


class Dome(CanvasShape):
    """The canvas `dome`. An argument left out has its default.

    radius: Radius of the sphere. [m] Default 0.3.
    centre: Centre of the sphere. [m] Default [0.6, 0, 0.4].
    opening_radius: Radius of the circle at which the cap ends: radius × sin(slope there). [m] Default 0.18.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        radius: float | None = None,
        centre: Sequence[float] | None = None,
        opening_radius: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("dome", "cap", {
            "radius": radius,
            "centre": centre,
            "opening_radius": opening_radius,
            "move": move,
            "turn": turn,
        })


class Plane(CanvasShape):
    """The canvas `plane`. An argument left out has its default.

    centre: Centre of the rectangle. [m] Default [0.6, 0, 0.1].
    normal: Normal of the side that is drawn on. Default [0, 0, 1].
    width: Size along x. [m] Default 0.36.
    height: Size at right angles to that. [m] Default 0.36.
    edge: Side of a mesh cell. [m] Default 0.01.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        centre: Sequence[float] | None = None,
        normal: Sequence[float] | None = None,
        width: float | None = None,
        height: float | None = None,
        edge: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("plane", "plane", {
            "centre": centre,
            "normal": normal,
            "width": width,
            "height": height,
            "edge": edge,
            "move": move,
            "turn": turn,
        })


class Wave(CanvasShape):
    """The canvas `wave`. An argument left out has its default.

    heading: Direction of the surface's x axis, counter-clockwise as seen from above. [deg] Default 0.
    amplitude: Amplitude of the wave: height = amplitude × sin(2π x/wavelength). [m] Default 0.015.
    wavelength: Wavelength along its x axis. [m] Default 0.2.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        heading: float | None = None,
        amplitude: float | None = None,
        wavelength: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("wave", "wave", {
            "heading": heading,
            "amplitude": amplitude,
            "wavelength": wavelength,
            "move": move,
            "turn": turn,
        })


class Saddle(CanvasShape):
    """The canvas `saddle`. An argument left out has its default.

    radius: Radius of curvature at the centre: height = (x² - y²)/(2 radius). [m] Default 0.4.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        radius: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("saddle", "saddle", {
            "radius": radius,
            "move": move,
            "turn": turn,
        })


class Cylinder(CanvasShape):
    """The canvas `cylinder`. An argument left out has its default.

    middle: Middle of the top line of a cylinder, or of the bottom line of a trough. [m] Default [0.6, 0, 0.1].
    heading: Direction of the level axis, counter-clockwise from x as seen from above. [deg] Default 0.
    radius: Radius of the cylinder. [m] Default 0.3.
    length: Length along the axis. [m] Default 0.36.
    width: Width as seen from above: 2 radius × sin(slope at its sides). [m] Default 0.36.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        middle: Sequence[float] | None = None,
        heading: float | None = None,
        radius: float | None = None,
        length: float | None = None,
        width: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("cylinder", "cylinder", {
            "middle": middle,
            "heading": heading,
            "radius": radius,
            "length": length,
            "width": width,
            "move": move,
            "turn": turn,
        })


class Trough(CanvasShape):
    """The canvas `trough`. An argument left out has its default.

    middle: Middle of the top line of a cylinder, or of the bottom line of a trough. [m] Default [0.6, 0, 0.1].
    heading: Direction of the level axis, counter-clockwise from x as seen from above. [deg] Default 0.
    radius: Radius of the cylinder. [m] Default 0.3.
    length: Length along the axis. [m] Default 0.36.
    width: Width as seen from above: 2 radius × sin(slope at its sides). [m] Default 0.36.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        middle: Sequence[float] | None = None,
        heading: float | None = None,
        radius: float | None = None,
        length: float | None = None,
        width: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("trough", "cylinder", {
            "middle": middle,
            "heading": heading,
            "radius": radius,
            "length": length,
            "width": width,
            "move": move,
            "turn": turn,
        })


class Cone(CanvasShape):
    """The canvas `cone`. An argument left out has its default.

    slope: Slope of its side; the half-angle is 90° minus the slope. [deg] Default 20.
    base_radius: Radius of the circle at which the cone ends. [m] Default 0.18.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        slope: float | None = None,
        base_radius: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("cone", "cone", {
            "slope": slope,
            "base_radius": base_radius,
            "move": move,
            "turn": turn,
        })


class Terrain(CanvasShape):
    """The canvas `terrain`. An argument left out has its default.

    seed: Seed of the terrain. Default 1.
    amplitude: Bound on the heights, above and below zero. [m] Default 0.04.
    feature: Shortest wavelength of the hills; the longest is twice that. [m] Default 0.2.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        seed: int | None = None,
        amplitude: float | None = None,
        feature: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("terrain", "terrain", {
            "seed": seed,
            "amplitude": amplitude,
            "feature": feature,
            "move": move,
            "turn": turn,
        })


class Rough(CanvasShape):
    """The canvas `rough`. An argument left out has its default.

    form: Hills at every scale down to the wavelength; flat facets of that size; a zigzag; a cylinder with waves along it; a step; a hole of that diameter; or a sheet above half of another. Default fractal.
    seed: Seed of a fractal or of facets. Default 1.
    slope: Root-mean-square slope. [deg] Default 10.
    wavelength: Shortest wavelength, side of a facet, or diameter of the hole. [m] Default 0.015.
    rise: Height of the step, or of the upper sheet. [m] Default 0.01.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        form: str | None = None,
        seed: int | None = None,
        slope: float | None = None,
        wavelength: float | None = None,
        rise: float | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("rough", "rough", {
            "form": form,
            "seed": seed,
            "slope": slope,
            "wavelength": wavelength,
            "rise": rise,
            "move": move,
            "turn": turn,
        })


class Mesh(CanvasShape):
    """The canvas `mesh`. An argument left out has its default.

    file: Mesh file: .obj, .stl, .ply, .off, .glb, .gltf, .3mf or .dae. Default .
    unit: Unit of the numbers in the file; file: what it says (.glb, .gltf, .3mf, .dae), else m. Default file.
    up: Axis that points up in the file; .glb, .gltf, .3mf and .dae say it themselves. Default z.
    recentre: Moves the middle of its extent in x and y, and its lowest point, to the file's origin. Default False.
    position: Position of the file's origin. [m] Default [0, 0, 0].
    rotation: Roll, pitch and yaw: rotations about the world's x, then y, then z axis. [deg] Default [0, 0, 0].
    side: Side that is drawn on; outward: the front of its triangles, and the outside of a closed mesh. Default outward.
    move: Translation of the whole canvas, after its rotation. [m] Default [0, 0, 0].
    turn: Rotation of the whole canvas about the world's z axis. [deg] Default 0.
    """

    def __init__(
        self,
        *,
        file: str | None = None,
        unit: str | None = None,
        up: str | None = None,
        recentre: bool | None = None,
        position: Sequence[float] | None = None,
        rotation: Sequence[float] | None = None,
        side: str | None = None,
        move: Sequence[float] | None = None,
        turn: float | None = None,
    ) -> None:
        super().__init__("mesh", "mesh", {
            "file": file,
            "unit": unit,
            "up": up,
            "recentre": recentre,
            "position": position,
            "rotation": rotation,
            "side": side,
            "move": move,
            "turn": turn,
        })


__all__ = [
    "CanvasShape",
    "Bowl",
    "Dome",
    "Plane",
    "Wave",
    "Saddle",
    "Cylinder",
    "Trough",
    "Cone",
    "Terrain",
    "Rough",
    "Mesh",
]
