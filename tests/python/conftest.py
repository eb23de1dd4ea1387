import os

import hypothesis
import numpy as np
import pytest

import impedraw as idr

# The same inputs each time in CI; IMPEDRAW_LONG=1 draws ten times as many, by another seed.
LONG = bool(os.environ.get("IMPEDRAW_LONG"))
hypothesis.settings.register_profile(
    "ci", max_examples=300 if LONG else 30, deadline=None, derandomize=not LONG, print_blob=True, database=None
)
hypothesis.settings.load_profile("ci")

POSTURE = np.array([0.1, 0.6, -0.1, -1.4, 0.2, 1.1, 0.3])


@pytest.fixture
def arm() -> idr.ArmModel:
    return idr.ArmModel.standard()


@pytest.fixture
def posture() -> np.ndarray:
    return POSTURE.copy()
