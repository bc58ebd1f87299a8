"""What is compiled is compiled before: it takes longer than a command may."""

import pytest

from hsr_pin.simulation.compiled import precompile


@pytest.fixture(scope="session", autouse=True)
def compiled():
    precompile()
    precompile(space=True)
