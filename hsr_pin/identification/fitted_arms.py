"""The fitted arms, one for each stiffness level, as specifications that can be written or simulated."""

from __future__ import annotations

from dataclasses import replace

from hsr_pin.identification.experiment import Experiment
from hsr_pin.inference.fit import Fit
from hsr_pin.robot.specification import ArmSpecification


def fitted_arms(experiment: Experiment, fit: Fit) -> dict[float, ArmSpecification]:
    """Return the fitted arm for each declared Keq [Nm/rad], with the changes of its effects to bodies and mount.

    The payload is that of the level's first trial. Laws that a specification cannot contain (friction, for example) are not
    included.
    """
    arms: dict[float, ArmSpecification] = {}
    for run in experiment.runs:
        if run.trial.keq not in arms:
            arm = fit.hypothesis.arm_batch(experiment, run, fit.values[None]).arms.specification(0)
            arms[run.trial.keq] = replace(arm, bending_limit=ArmSpecification.bending_limit)
    return arms
