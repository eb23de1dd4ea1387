"""Settings as Python gives them, to the texts that ``./impedraw draw --set`` takes."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any


def _text(value: Any) -> str:
    if hasattr(value, "tolist"):  # NumPy's arrays and numbers
        value = value.tolist()
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, (list, tuple)):
        return json.dumps([_plain(v) for v in value])
    raise ValueError(
        f"a setting is of type {type(value).__name__}; "
        "valid are numbers, texts, truth values, None, sequences of them and mappings"
    )


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return value


def assignments(settings: Mapping[str, Any], prefix: str = "") -> list[str]:
    """``{"control": {"normal_force": 3}}`` or ``{"control.normal_force": 3}`` to
    ``["control.normal_force=3"]``."""
    result = []
    for key, value in settings.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            result += assignments(value, name + ".")
        else:
            result.append(f"{name}={_text(value)}")
    return result
