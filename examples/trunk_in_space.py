"""Fit releases of a real trunk with one load, predict those with another load, and compare models in space and in a plane.

    python examples/trunk_in_space.py ../shared/recordings/real-trunk-space

The model in a plane starts each release in the vertical plane through the tip, and stays in this plane.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.effects import parse_effect
from hsr_pin.identification.choice import choose
from hsr_pin.identification.experiment import Experiment, prepare, restricted
from hsr_pin.identification.identify import simulated
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import rms
from hsr_pin.recordings.read import read_dataset

LIGHT = 0.25  # [kg] releases with a smaller load are fitted, the others are held out
DELAY, DURATION = 0.1, 2.0  # [s] used part of a release: begin after its declared start, and duration
ARM = ("keq", "damping", "mass")
BEND, LOOP = "bend_at_rest:towards_x=0,towards_y=0", "hysteresis:amplitude=0.5,yield_angle=0.1"


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Print the fits, and return the RMS marker distance of each model on the held-out releases [mm]."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", help="the folder of real-trunk-space")
    parser.add_argument("--quick", action="store_true", help="without hysteresis")
    chosen = parser.parse_args(arguments)
    whole = prepare(replace(read_dataset(chosen.dataset), bending="space"), delay=DELAY)
    whole = replace(whole, runs=tuple(map(begun, whole.runs)))
    light, heavy = (
        restricted(whole, [run.trial.name for run in whole.runs if (run.trial.tip_mass < LIGHT) is below])
        for below in (True, False)
    )
    light, heavy = replace(light, rest_scatter=0.0), replace(heavy, rest_scatter=0.0)  # the model has to predict the equilibrium
    print(f"{len(light.runs)} releases fitted, {len(heavy.runs)} held out; RMS distance of the markers over {DURATION:g} s [mm]")
    found = {}
    for words in ([], [LOOP])[: 1 if chosen.quick else 2]:
        for place in ("plane", "space"):
            effects = tuple(map(parse_effect, ([BEND] if place == "space" else []) + words))
            model = choose(ARM, effects, light.runs, links=8, placement="shifted")
            fitted, judged = (light, heavy) if place == "space" else (in_planes(light), in_planes(heavy))
            answer = fit(fitted, model)
            name = " + ".join([place, *(effect.name for effect in effects)])
            found[name] = 1e3 * rms(simulated(judged, model, answer.values))
            print(f"{name:34} fitted {1e3 * rms(answer.raw_residuals):5.2f}   held out {found[name]:5.2f}")
            print("   ", ", ".join(f"{key} {value:.3g}" for key, value in answer.named.items()))
    return found


def begun(run: Run) -> Run:
    """Return a release, cut to the common duration."""
    count = round(DURATION / run.step) + 1
    return replace(run, time=run.time[:count], torque=run.torque[:count], measured=run.measured[:count])


def in_planes(experiment: Experiment) -> Experiment:
    """Return the releases, each started in the vertical plane through its tip."""
    return replace(experiment, runs=tuple(map(in_its_plane, experiment.runs)))


def in_its_plane(run: Run) -> Run:
    """Return one release, started in the vertical plane through its tip."""
    assert run.start_pose is not None and run.start_velocity is not None
    way = run.start_pose[-1] * [1.0, 1.0, 0.0]
    across = np.cross([0.0, 0.0, 1.0], way / np.linalg.norm(way))
    pose, velocity = (part - np.outer(part @ across, across) for part in (run.start_pose, run.start_velocity))
    return replace(run, start_pose=pose, start_velocity=velocity, found_poses={})


if __name__ == "__main__":
    main()
