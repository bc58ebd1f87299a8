"""An exported model in MuJoCo, and the same program in hsr_pin."""

import contextlib
import itertools
import sys
from importlib.util import module_from_spec, spec_from_file_location

import numpy as np

from hsr_pin.blind.plants.program import LEVELS, chirp, staircase, steps
from hsr_pin.export.file import module_path, write
from hsr_pin.export.mjcf import to_mjcf
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.simulate import simulate

SAMPLE = 0.01
_numbers = itertools.count()


def programs(keq, links, *, quick=False):
    """Name -> (torques, start): the blind check's, or short ones."""
    top = LEVELS[keq][1][2]
    bent = np.linspace(1.6, 0.4, links) / links
    releases = {
        "release of a couple": (np.zeros(101), Settled(0.7 * keq)),
        "release of a pull": (np.zeros(101), Pose(bent)),
    }
    if quick:
        step = np.where(np.arange(81) >= 10, 0.8 * top, 0.0)
        return {"step": (step, Settled()), "release of a pull": (np.zeros(51), Pose(bent))}
    named = {f"step {n + 1}": (trial.torque(), Settled()) for n, trial in enumerate(steps(keq))}
    named |= {"staircase": (staircase(keq)[0].torque(), Settled()), "chirp": (chirp(keq)[0].torque(), Settled())}
    return named | releases


def worst_gap(model, folder, *, quick=False, major=4, bend=1.0):
    """Program -> largest distance [mm] of any marker, at any sample, between MuJoCo's motion and ours."""
    path = folder / f"arm{next(_numbers)}.xml"
    write(to_mjcf(model, laws=module_path(path).stem, major=major), path)
    gaps = {}
    for name, (torque, start) in programs(model.arm.keq, model.arm.links, quick=quick).items():
        scenario = Scenario(model.arm, np.arange(len(torque)) * SAMPLE, bend * torque, start, model.effects, model.markers)
        ours = simulate(scenario, tolerance=1e-6).trajectory
        theirs = motion(path, bend * torque, ours.joint_angles[0], start.torque if isinstance(start, Settled) else 0.0)
        gaps[name] = 1e3 * float(np.linalg.norm(theirs - ours.positions, axis=2).max())
    return gaps


def motion(path, torque, angles, before=0.0, markers=("base", "mid", "tip")):
    """(T, M, 3) [m] of the markers under torques (T,) held for 10 ms each, from a pose, settled there under a torque."""
    import mujoco

    with laws_of(path) as laws:
        model = mujoco.MjModel.from_xml_path(str(path))
        if laws is not None and hasattr(laws, "install"):
            laws.install(model)
        data = mujoco.MjData(model)
        if laws is not None:
            laws.start(model, data, angles, before)
        else:
            data.qpos[:], data.ctrl[:], data.act[:] = angles, before, before
            if model.nhistory:
                mujoco.mj_initCtrlHistory(model, data, 0, None, np.full((model.actuator_history[0, 0], 1), before))
        substeps = round(SAMPLE / model.opt.timestep)
        seen = np.empty((len(torque), len(markers), 3))
        for n, command in enumerate(torque):
            mujoco.mj_kinematics(model, data)
            seen[n] = [data.site(name).xpos for name in markers]
            data.ctrl[0] = command
            mujoco.mj_step(model, data, nstep=substeps)
        return seen


@contextlib.contextmanager
def laws_of(path):
    """The module beside a file, or None; what it installs is taken away again."""
    import mujoco

    beside = module_path(path)
    if not beside.exists():
        yield None
        return
    spec = spec_from_file_location(beside.stem, beside)
    module = module_from_spec(spec)
    sys.modules[beside.stem] = module
    spec.loader.exec_module(module)
    try:
        yield module
    finally:
        mujoco.set_mjcb_passive(None)
        mujoco.set_mjcb_act_dyn(None)
        del sys.modules[beside.stem]
