"""Simulate each effect of the catalogue with hsr-sim, diagnose the recording, and print the result.

    python scripts/self_test.py [EFFECT ...]

This is no evidence of accuracy, because simulation and diagnosis use the same model. It shows what the default experiment, three
steps from rest at one stiffness, can distinguish if everything else is exact. It takes about ten minutes on two cores.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import numpy as np

from hsr_pin import diagnose
from hsr_pin.diagnosis.result import Diagnosis
from hsr_pin.effects.catalogue import parse_effect
from hsr_pin.inference.uncertainty import uncertainty

#: Every effect, with a size that is clearly visible.
CASES = (
    "stiffness_gradient:slope=-0.9",
    "soft_spot:depth=0.7,centre=0.35,width=0.08",
    "preset_bend:angle=0.1",
    "stiffening:cubic=0.4",
    "bending_stop:ratio=6,angle=0.5",
    "backlash:gap=0.2",
    "dry_friction:level=0.05",
    "hysteresis:amplitude=0.12,yield_angle=0.25",
    "viscoelastic:ratio=0.4,time_constant=0.4",
    "quadratic_damping:coefficient=0.008",
    "damping_gradient:slope=1.5",
    "actuator_lag:time_constant=0.08",
    "unequal_lag:rise=0.05,fall=0.2",
    "partial_lag:time_constant=0.2,at_once=0.5",
    "ringing_drive:period=0.25,damping_ratio=0.2",
    "dead_time:delay=0.045",
    "torque_bias:bias=0.1",
    "partial_bias:bias=0.1,start=0.5",
    "torque_map:quadratic=0.2",
    "torque_decay:decay=0.3",
    "one_sided_cable:lost=0.6",
    "capstan_friction:friction=0.25",
    "gravity_tilt:angle=0.12",
    "tip_mass:mass=0.05",
    "added_mass:mass=0.08",
    "restraint:contact_stiffness=20",
    "obstacle:hardness=200000,gap=0.015,at=0.6",
    "side_force:force=0.2",
    "marker_offset:offset=0.006",
    "marker_slip:slip=0.006",
    "length_change:depth=0.01",
    "camera_scale:scale=0.03",
)


#: Torques of the steps [N m] for an effect that the default steps, all to one side, do not show.
BOTH_SIDES = {"one_sided_cable": ("-0.8", "0.5", "1.0")}


def recorded(effect: str, folder: Path) -> Path:
    """Return the dataset that hsr-sim writes with an effect."""
    command = [Path(sys.executable).parent / "hsr-sim", "--effect", effect, "--csv", folder / "made"]
    command += [word for torque in BOTH_SIDES.get(effect.partition(":")[0], ()) for word in ("--torque", torque)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "made"


def told(found: Diagnosis, effect: str) -> str:
    """Return how the diagnosis reports the true effect: named, among alternatives or not found, and with which values."""
    law, verdict = parse_effect(effect), found.verdict
    sets = verdict.alternatives or (verdict.effects,)
    special = [names[0] for names in sets if len(names) == 1 and names[0] in law.contains]
    if special:
        return f"its special case {special[0]} is named: these steps do not tell them apart"
    if (law.name,) not in sets:
        return f"NOT FOUND: {verdict.sentence}"
    grade = "named" if len(sets) == 1 else f"one of {len(sets)} alternatives"
    assert found.search is not None
    fit = found.search.leader((law.name,)).fit
    wanted = {f"{law.name}.{fact.name}": getattr(law, fact.name) for fact in law.parameters()}
    own = [(name, *bounds) for name, bounds in zip(fit.named, uncertainty(fit).interval, strict=True) if name in wanted]
    off = [f"{name} {low:.4g} to {high:.4g} for {wanted[name]:g}" for name, low, high in own if not low <= wanted[name] <= high]
    return f"{grade}; {'; '.join(off) or 'every value within its interval'}"


def main() -> None:
    """Print one line for each effect."""
    for effect in [each for each in CASES if not sys.argv[1:] or each.partition(":")[0] in sys.argv[1:]]:
        with TemporaryDirectory() as folder:
            found = diagnose(recorded(effect, Path(folder)))
        print(f"{effect:<46} {told(found, effect)}", flush=True)


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
