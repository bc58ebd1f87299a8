"""Parameters of a MuJoCo model are selected by name, and a missing cause among them is named."""

import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.explain import Cause, Trial, amplitude, explain
from hsr_pin.explain.mujoco import MujocoInputs, MujocoModel, Opened, opened

mujoco = pytest.importorskip("mujoco", reason="needs MuJoCo")
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
TIME = np.arange(0, 1, 0.01)
XML = """<mujoco><option timestep="0.005" integrator="implicitfast"/>
<worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.02" mass="1"/></body></worldbody>
<actuator><motor name="motor" joint="hinge"/></actuator><sensor><jointpos name="angle" joint="hinge"/></sensor></mujoco>"""


def one(*causes, channel="hinge"):
    return MujocoModel(XML, {"q": channel}, causes)


def trial(torque=0.5):
    inputs = MujocoInputs(np.where(TIME[:, None] > 0.2, torque, 0.0), qpos=np.zeros(1), qvel=np.zeros(1))
    return Trial("one", TIME, {"q": 0 * TIME}, inputs)


def test_the_declared_model_moves_as_mujoco_moves_it():
    model, data, seen = mujoco.MjModel.from_xml_string(XML), None, []
    data = mujoco.MjData(model)
    for n in range(len(TIME)):
        seen.append(float(data.qpos[0]))
        for _ in range(2):
            data.ctrl[:] = 0.5 if TIME[n] > 0.2 else 0.0
            mujoco.mj_step(model, data)
    found = one().predict({}, trial())
    assert found["q"] == pytest.approx(np.array(seen), abs=1e-12)
    assert one(channel="angle").predict({}, trial())["q"] == pytest.approx(np.array(seen), abs=1e-12)


@pytest.mark.parametrize(
    ("field", "element", "size"),
    [
        ("dof_frictionloss", "hinge", 0.2),
        ("dof_damping", "hinge", 0.2),
        ("dof_armature", "hinge", 0.05),
        ("body_mass", "arm", 0.3),
    ],
)
def test_a_number_is_changed_by_what_is_asked_for_and_stays_declared_otherwise(field, element, size):
    model = one(opened("cause", "kind", field, [amplitude(element, 0.1)]))
    declared = float(np.ravel(getattr(model.declared, field))[-1])
    moved = model.predict({f"cause.{element}": size}, trial())["q"]
    assert np.abs(moved - model.predict({f"cause.{element}": 0.0}, trial())["q"]).max() > 1e-3
    assert float(np.ravel(getattr(model.declared, field))[-1]) == declared


def test_a_delay_and_a_force_of_ones_own_act():
    def spring(model, data, values):
        data.qfrc_applied[0] = -values["stiffness"] * data.qpos[0]

    late = Opened(Cause("late", "time", (amplitude("delay", 0.02, "s"),)), delay=True)
    own = Opened(Cause("spring", "elastic", (amplitude("stiffness", 1.0),)), force=spring)
    model = one(late, own)
    plain = model.predict({"late.delay": 0.0, "spring.stiffness": 0.0}, trial())["q"]
    later = model.predict({"late.delay": 0.1, "spring.stiffness": 0.0}, trial())["q"]
    assert later[10:] == pytest.approx(plain[:-10], abs=1e-9)
    assert np.abs(model.predict({"late.delay": 0.0, "spring.stiffness": 5.0}, trial())["q"]).max() < np.abs(plain).max()


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: one(opened("c", "k", "dof_friction", [amplitude("hinge", 1)])), "dof_friction"),
        (lambda: one(opened("c", "k", "dof_damping", [amplitude("hing", 1)])), "a joint of the model"),
        (lambda: one(channel="tip"), "a sensor or a joint"),
    ],
)
def test_what_the_model_has_not_is_refused(build, words):
    with pytest.raises(InputError, match=words):
        _ = build().as_model


def test_it_can_be_sent_to_other_processes():
    model = one(opened("cause", "kind", "dof_damping", [amplitude("hinge", 0.1)]))
    _ = model.as_model
    copy = pickle.loads(pickle.dumps(model))
    assert copy.predict({"cause.hinge": 0.1}, trial())["q"] == pytest.approx(model.predict({"cause.hinge": 0.1}, trial())["q"])


def test_the_friction_that_a_finer_simulation_has_is_named():
    from explain_mujoco import model, recorded

    found = explain(model().as_model, recorded(friction__elbow=0.15)[:3], causes=["friction", "damping", "gear"], max_causes=1)
    assert found.verdict.effects == ("friction",)
    assert found.values["friction.elbow"] == pytest.approx(0.15, rel=0.05)
