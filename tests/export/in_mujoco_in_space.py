"""An exported arm in space in MuJoCo, and the same programs in hsr_pin."""

import itertools

import numpy as np

from hsr_pin.export.file import module_path, write
from hsr_pin.export.mjcf import to_mjcf
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.simulate import simulate

from .in_mujoco import SAMPLE, laws_of

_numbers = itertools.count()


def programs(model):
    """Name -> (torques (T, 2 S), start): a torque that goes round, a step to one side, a release from a curl in no plane."""
    links, keq, parts = model.arm.links, model.arm.keq, model.inputs
    time = np.arange(81) * SAMPLE
    rounds = 1.1 * keq * np.stack([np.cos(8 * time), np.sin(8 * time)], axis=1) * np.minimum(time / 0.3, 1)[:, None]
    step = np.where(time[:, None] >= 0.1, 0.8 * keq * np.array([np.cos(2.2), np.sin(2.2)]), 0.0)
    sides = np.exp(1j * np.linspace(0.0, 2.5, links)) * np.linspace(1.6, 0.4, links) / links
    curl = Pose(np.stack([sides.real, sides.imag, np.zeros(links)], axis=1))
    sections = 0.5 ** np.repeat(np.arange(parts), 2)
    return {
        "round": (np.tile(rounds, parts) * sections, Settled()),
        "step": (np.tile(step, parts) * sections, Settled()),
        "release": (np.zeros((61, 2 * parts)), curl),
        "release of a couple": (np.zeros((61, 2 * parts)), Settled(0.5 * keq * (1 - 1j))),
    }


def worst_gap(model, folder, *, major=4, names=("round", "step", "release")):
    """Program -> largest distance [mm] of any marker, at any sample, between MuJoCo's motion and ours."""
    path = folder / f"space{next(_numbers)}.xml"
    write(to_mjcf(model, laws=module_path(path).stem, major=major), path)
    gaps = {}
    for name, (torque, start) in programs(model).items():
        if name in names:
            scenario = Scenario(model.arm, np.arange(len(torque)) * SAMPLE, torque, start, model.effects, model.markers)
            ours = simulate(scenario, tolerance=1e-6).trajectory
            held = start.torque if isinstance(start, Settled) else 0.0
            theirs = motion(path, torque, ours.joint_angles[0], held, [marker.name for marker in model.markers])
            gaps[name] = 1e3 * float(np.linalg.norm(theirs - ours.positions, axis=2).max())
    return gaps


def motion(path, torque, angles, before=0.0, markers=("base", "mid", "tip")):
    """(T, M, 3) [m] of the markers under torques (T, 2 S) held for 10 ms each, from a pose (N, 3) settled under a torque."""
    import mujoco

    with laws_of(path) as laws:
        model = mujoco.MjModel.from_xml_path(str(path))
        if laws is not None:
            if hasattr(laws, "install"):
                laws.install(model)
            data = mujoco.MjData(model)
            laws.start(model, data, angles, before)
        else:
            data = started(model, angles, before)
        substeps = round(SAMPLE / model.opt.timestep)
        seen = np.empty((len(torque), len(markers), 3))
        for n, command in enumerate(torque):
            mujoco.mj_kinematics(model, data)
            seen[n] = [data.site(name).xpos for name in markers]
            data.ctrl[:] = command
            mujoco.mj_step(model, data, nstep=substeps)
        return seen


def started(model, angles, before):
    """As the file's comment says: without a module."""
    import mujoco

    data = mujoco.MjData(model)
    for i, joint in enumerate(angles):
        for way, angle in zip(("x", "y", "twist"), joint, strict=True):
            name = f"joint_{i + 1}_{way}"
            if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) >= 0:
                data.qpos[model.joint(name).qposadr[0]] = angle
    held = np.tile([np.real(before), np.imag(before)], model.nu // 2)
    data.ctrl[:] = held
    if model.na:
        data.act[:] = held
    for k in range(model.nu if model.nhistory else 0):
        mujoco.mj_initCtrlHistory(model, data, k, None, np.full((model.actuator_history[k, 0], 1), held[k]))
    return data
