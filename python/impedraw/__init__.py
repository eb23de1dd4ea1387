"""impedraw: a pen on a robot arm draws on unknown curved surfaces under operational-space impedance
control.

``draw()`` runs a whole drawing. ``ImpedanceController``, ``ArmModel``, ``WrenchEstimator``,
``JointStateEstimator``, ``SurfaceEstimator`` and ``plan_tip_path()`` are the parts of it for a loop
of your own, and ``World`` is the simulated arm, step by step. Quantities are SI; vectors are in the
world frame W unless a name says otherwise; spatial vectors have the linear part first, at the origin
of the pen tip's frame E.
"""

from __future__ import annotations

import importlib
import os
import pathlib
import sys
from typing import TYPE_CHECKING, Any

from . import _impedraw
from ._impedraw import (
    TORQUE_TERMS,
    ApproachSettings,
    ArmLimits,
    ArmModel,
    ArmTerms,
    AxialGain,
    Canvas,
    ContactMode,
    ContactSettings,
    ControlStatus,
    ErrorProjection,
    Finding,
    ForceIntegralSettings,
    FrictionSettings,
    ImpedanceController,
    ImpedanceSettings,
    ImpedanceTorque,
    InertiaShaping,
    JointRangeSettings,
    JointSensor,
    JointSensorSettings,
    JointStateEstimator,
    JointStateEstimatorSettings,
    LimitSettings,
    ModelErrors,
    NeighbourWeighting,
    NormalSettings,
    NullSpaceSettings,
    ObserverSettings,
    OperationalSpaceSettings,
    PathSample,
    PathSettings,
    PenAxis,
    Phase,
    Pose,
    Preflight,
    PreflightMargins,
    PreflightSettings,
    Problem,
    StabilityCheckSettings,
    StrokePart,
    SurfaceEstimate,
    SurfaceEstimator,
    SurfaceFit,
    SurfacePoint,
    SurfaceSettings,
    SurfaceStatus,
    TimingSettings,
    TipContact,
    TipGain,
    TipMaterial,
    TipPath,
    TipReference,
    TipSettings,
    Tool,
    ToolIdentification,
    VelocityReading,
    World,
    WorldSettings,
    WorldState,
    WrenchEstimator,
    WrenchEstimatorSettings,
    WrenchFeedback,
    check_strokes,
    check_transitions,
    identify_tool,
    plan_tip_path,
)
from ._draw import draw, plan
from ._metrics import Metrics
from ._run import Log, Run
from ._sweep import Sweep, sweep
from .canvases import (
    Bowl,
    CanvasShape,
    Cone,
    Cylinder,
    Dome,
    Mesh,
    Plane,
    Rough,
    Saddle,
    Terrain,
    Trough,
    Wave,
)

if TYPE_CHECKING:
    from . import gym as gym

_data = pathlib.Path(__file__).parent / "data"
if _data.is_dir():  # of a wheel; in a source tree the library knows where it stands
    _impedraw.set_data_folder(str(_data))
    _impedraw.set_python(sys.executable)
    _impedraw.set_command("impedraw")
    if not os.path.exists("/etc/fonts/fonts.conf"):  # a system without fonts
        os.environ.setdefault("FONTCONFIG_FILE", str(_data / "fonts/fonts.conf"))


def __getattr__(name: str) -> Any:
    if name == "gym":  # it needs more than NumPy
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "TORQUE_TERMS",
    "ApproachSettings",
    "ArmLimits",
    "ArmModel",
    "ArmTerms",
    "AxialGain",
    "Bowl",
    "Canvas",
    "CanvasShape",
    "Cone",
    "ContactMode",
    "ContactSettings",
    "ControlStatus",
    "Cylinder",
    "Dome",
    "ErrorProjection",
    "Finding",
    "ForceIntegralSettings",
    "FrictionSettings",
    "ImpedanceController",
    "ImpedanceSettings",
    "ImpedanceTorque",
    "InertiaShaping",
    "JointRangeSettings",
    "JointSensor",
    "JointSensorSettings",
    "JointStateEstimator",
    "JointStateEstimatorSettings",
    "LimitSettings",
    "Log",
    "Mesh",
    "Metrics",
    "ModelErrors",
    "NeighbourWeighting",
    "NormalSettings",
    "NullSpaceSettings",
    "ObserverSettings",
    "OperationalSpaceSettings",
    "PathSample",
    "PathSettings",
    "PenAxis",
    "Phase",
    "Plane",
    "Pose",
    "Preflight",
    "PreflightMargins",
    "PreflightSettings",
    "Problem",
    "Rough",
    "Run",
    "Saddle",
    "StabilityCheckSettings",
    "StrokePart",
    "SurfaceEstimate",
    "SurfaceEstimator",
    "SurfaceFit",
    "SurfacePoint",
    "SurfaceSettings",
    "SurfaceStatus",
    "Sweep",
    "Terrain",
    "TimingSettings",
    "TipContact",
    "TipGain",
    "TipMaterial",
    "TipPath",
    "TipReference",
    "TipSettings",
    "Tool",
    "ToolIdentification",
    "Trough",
    "VelocityReading",
    "Wave",
    "World",
    "WorldSettings",
    "WorldState",
    "WrenchEstimator",
    "WrenchEstimatorSettings",
    "WrenchFeedback",
    "check_strokes",
    "check_transitions",
    "draw",
    "identify_tool",
    "plan",
    "plan_tip_path",
    "sweep",
]
