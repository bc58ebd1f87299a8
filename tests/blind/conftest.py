"""Engines of the plants."""

import pytest


@pytest.fixture
def engines():
    """Skip the test unless both engines are installed."""
    pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")
    pytest.importorskip("elastica", reason="pyelastica is not installed (dependency group blind)")
