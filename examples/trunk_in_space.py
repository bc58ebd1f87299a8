"""Fit a real trunk's releases in space under one load, judge the fit by those under another, and the same in planes.

    python examples/trunk_in_space.py ../shared/recordings/real-trunk-space

In a plane each release starts in the vertical plane through its tip, and stays there.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.effects import parse_effect
from hsr_pin.identification.fit_in_space import Release, fit_in_space, releases_of
from hsr_pin.recordings.read import read_dataset

LIGHT = 0.25  # [kg] loads below it are fitted, those above are held out
ARM = ("keq", "damping", "mass")
BEND, LOOP = "bend_at_rest:towards_x=0,towards_y=0", "hysteresis:amplitude=0.5,yield_angle=0.1"


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """RMS distance of the held-out markers [mm] by model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", help="the folder of real-trunk-space")
    parser.add_argument("--quick", action="store_true", help="without hysteresis")
    chosen = parser.parse_args(arguments)
    dataset = read_dataset(chosen.dataset)
    every = releases_of(dataset)
    light, heavy = ([r for r in every if (r.trial.tip_mass < LIGHT) is below] for below in (True, False))
    print(f"{len(light)} releases fitted, {len(heavy)} held out; RMS distance of the markers over 2 s [mm]")
    found = {}
    for words in ([], [LOOP])[: 1 if chosen.quick else 2]:
        for place in ("plane", "space"):
            effects = tuple(map(parse_effect, ([BEND] if place == "space" else []) + words))
            free = [*ARM, *(f"{effect.name}.{fact.name}" for effect in effects for fact in effect.parameters())]
            fitted, judged = (light, heavy) if place == "space" else ([*map(in_its_plane, rs)] for rs in (light, heavy))
            fit = fit_in_space(dataset, fitted, free, effects)
            name = " + ".join([place, *(effect.name for effect in effects)])
            found[name] = 1e3 * fit.predicted(dataset, judged).rms
            print(f"{name:34} fitted {1e3 * fit.rms:5.2f}   held out {found[name]:5.2f}")
            print("   ", ", ".join(f"{key} {value:.3g}" for key, value in fit.values.items()))
    return found


def in_its_plane(release: Release) -> Release:
    """Started in the vertical plane through its tip."""
    way = release.pose[-1] * [1.0, 1.0, 0.0]
    across = np.cross([0.0, 0.0, 1.0], way / np.linalg.norm(way))
    pose, velocity = (part - np.outer(part @ across, across) for part in (release.pose, release.velocity))
    return replace(release, pose=pose, velocity=velocity)


if __name__ == "__main__":
    main()
