"""Sample recordings that are installed with the package and found by name."""

from __future__ import annotations

from pathlib import Path

from hsr_pin.resources import resource

#: Name -> description. The licence and the source of each sample are in its folder in ``data/samples``.
SAMPLES = {
    "beam": "real: a silicone beam, released under gravity with and without a load at its tip",
    "beam-empty": "real: the releases of the sample beam without a load",
    "beam-loaded": "real: the releases of the sample beam with a load that is not declared",
    "valve-arm": "simulated by other authors: steps of pneumatic muscles behind valves, with one effect to be found",
}
#: Name -> description of the samples of rigid-link robots, which :func:`hsr_pin.robots.explain_robot` reads.
ROBOTS = {"double-pendulum": "real: a robot of two rigid links, with encoders and measured torques"}
#: Alias of the first sample.
FIRST = "sample"


def sample_folder(name: str) -> Path | None:
    """Return the folder of a sample dataset; None if no sample has this name."""
    if name == FIRST:
        name = next(iter(SAMPLES))
    return resource("data", f"samples/{name}/dataset.toml").parent if name in SAMPLES else None


def robot_folder(name: str) -> Path | None:
    """Return the folder of a sample of a rigid-link robot; None if no sample has this name."""
    return resource("data", f"samples/{name}/robot.toml").parent if name in ROBOTS else None
