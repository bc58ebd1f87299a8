"""Sample recordings that come with the package, found by name from anywhere."""

from __future__ import annotations

from pathlib import Path

from hsr_pin.resources import resource

#: Name -> what it holds. Licence and source stand beside each in ``data/samples``.
SAMPLES = {
    "beam": "real: a silicone beam, released under gravity with and without a load at its tip",
    "beam-empty": "real: the releases of beam without a load",
    "beam-loaded": "real: the releases of beam with a load that is not declared",
    "valve-arm": "simulated by other authors: pneumatic muscles behind valves, stepped, with one effect to be found",
}
#: The same of robots of rigid links, which :func:`hsr_pin.robots.explain_robot` takes.
ROBOTS = {"double-pendulum": "real: a robot of two rigid links, with encoders and measured torques"}
#: The name that stands for the first of them.
FIRST = "sample"


def sample_folder(name: str) -> Path | None:
    """The folder of a sample; None where there is no sample of this name."""
    if name == FIRST:
        name = next(iter(SAMPLES))
    return resource("data", f"samples/{name}/dataset.toml").parent if name in SAMPLES else None


def robot_folder(name: str) -> Path | None:
    """The folder of a sample of a robot; None where there is no sample of this name."""
    return resource("data", f"samples/{name}/robot.toml").parent if name in ROBOTS else None
