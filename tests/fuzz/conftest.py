"""What is compiled is compiled before: it takes longer than a command may."""

import pytest

from hsr_pin.simulation.compiled import ready


@pytest.fixture(scope="session", autouse=True)
def compiled():
    ready()
    ready(space=True)
