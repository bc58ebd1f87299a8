"""The benchmark problem in MuJoCo: the same bodies, springs and dampers, without any unnecessary computation.

E. Todorov, T. Erez, Y. Tassa, MuJoCo: a physics engine for model-based control, IROS 2012. The torque enters as the rest angle of
the springs, which costs MuJoCo no time. Models and data are set up beforehand.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from mujoco.rollout import Rollout
from problem import DURATION, SAMPLE, TORQUE

from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

#: The quickest first: what is slower than the best so far need not be tried to the end. MuJoCo has "discrete" from 3.13 on.
METHODS = {
    name: getattr(mujoco.mjtIntegrator, f"mjINT_{name.upper()}")
    for name in ("Euler", "discrete", "implicitfast", "implicit", "RK4")
    if hasattr(mujoco.mjtIntegrator, f"mjINT_{name.upper()}")
}
_UNUSED = ("CONSTRAINT", "CONTACT", "ACTUATION", "SENSOR", "WARMSTART")

mujoco.set_mju_user_warning(lambda _: None)  # steps that diverge are part of the search


class MujocoChain:
    """A solver for one arm: `mj_step`, looping in C from sample to sample.

    Args:
        arm: arm to simulate.
        method: integrator.
        substeps: steps per sample.
        sample: time between samples [s].
    """

    def __init__(self, arm: ArmSpecification, method: str, substeps: int, sample: float = SAMPLE) -> None:
        step = sample / substeps
        self.substeps, self.setting = substeps, _setting(method, step)
        self.model, self._samples = mujoco_model(arm, method, step), round(DURATION / sample)
        self.data = mujoco.MjData(self.model)

    def run(self) -> Array:
        """Return the joint angles, see `Solver`."""
        mujoco.mj_resetData(self.model, self.data)
        angles = np.zeros((self._samples + 1, 1, self.model.nv))
        for n in range(1, len(angles)):
            mujoco.mj_step(self.model, self.data, nstep=self.substeps)
            angles[n, 0] = self.data.qpos
        return angles

    def advance(self, steps: int) -> None:
        """Simulate steps of MuJoCo from the current state."""
        mujoco.mj_step(self.model, self.data, nstep=steps)


class MujocoRollout:
    """A solver for many arms: `mujoco.rollout` from sample to sample with persistent threads.

    Args:
        arms: arms with equal ``links``.
        threads: number of threads of the rollout.
        method: integrator.
        substeps: steps per sample.
    """

    def __init__(self, arms: Sequence[ArmSpecification], threads: int, method: str, substeps: int) -> None:
        step = SAMPLE / substeps
        self.method, self.substeps, self.setting = method, substeps, _setting(method, step)
        self._models = [mujoco_model(arm, method, step) for arm in arms]
        self._data = [mujoco.MjData(self._models[0]) for _ in range(threads)]
        self._rollout = Rollout(nthread=threads)
        size = mujoco.mj_stateSize(self._models[0], mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self._states = np.empty((len(arms), substeps, size))

    def run(self) -> Array:
        """Return the joint angles, see `Solver`."""
        joints, (count, substeps, size) = self._models[0].nv, self._states.shape
        state, angles = np.zeros((count, size)), np.zeros((round(DURATION / SAMPLE) + 1, count, joints))
        for n in range(1, len(angles)):
            self._rollout.rollout(self._models, self._data, state, nstep=substeps, state=self._states)
            state = self._states[:, -1].copy()
            angles[n] = state[:, 1 : joints + 1]  # after the time
        return angles


def mujoco_model(arm: ArmSpecification, method: str, step: float) -> mujoco.MjModel:
    """Return the MuJoCo model of an arm with the bodies of its Pinocchio model, for an integrator with a ``step`` [s]."""
    body_model = build_model(arm).model
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.integrator = step, METHODS[method]
    spec.option.gravity = body_model.gravity.linear
    spec.option.disableflags = sum(int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}")) for name in _UNUSED)
    body, turn = spec.worldbody, np.zeros(4)
    for place, inertia in zip(body_model.jointPlacements[1:], body_model.inertias[1:], strict=True):
        mujoco.mju_mat2Quat(turn, place.rotation.ravel())
        body = body.add_body(pos=place.translation, quat=turn, explicitinertial=True)
        body.mass, body.ipos, body.inertia = inertia.mass, inertia.lever, np.diag(inertia.inertia)
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0])
    model = spec.compile()
    model.jnt_stiffness[:], model.dof_damping[:] = arm.joint_stiffness, arm.joint_damping
    model.qpos_spring[:] = TORQUE / arm.joint_stiffness
    return model


def _setting(method: str, step: float) -> str:
    return f"{method}, {1e3 * step:.3g} ms"
