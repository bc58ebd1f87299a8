"""Exported MJCF moves in MuJoCo as the model does in hsr_pin: to 0.5 mm, for every effect that can be expressed."""

import importlib.util
import subprocess
import sys
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.effects import EFFECTS, parse_effect
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, OutputError
from hsr_pin.export.file import write
from hsr_pin.export.mjcf import to_mjcf
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.parts import sort
from hsr_pin.parameters import amplitude
from hsr_pin.robot.chain import Arms, chain_of, mass_matrix
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification

from .in_mujoco import laws_of, motion, worst_gap

mujoco = pytest.importorskip("mujoco")
if mujoco.mj_version() < 4000000:
    pytest.skip("needs MuJoCo 4, which needs Python 3.11", allow_module_level=True)

#: [mm] set by ourselves; what is within it is said to be the same.
LARGEST = 0.5
EXPRESSED = (
    "stiffness_gradient:slope=0.6",
    "soft_spot:depth=0.6",
    "stiffening:cubic=0.3",
    "stiffening:cubic=2",
    "stiffening:cubic=-0.15",
    "bending_stop:ratio=3,angle=0.6",
    "bending_stop:ratio=3,angle=0.4,side=positive",
    "backlash:gap=0.2",
    "dry_friction:level=0.1",
    "dry_friction:level=0.1,form=load",
    "hysteresis:amplitude=0.2",
    "hysteresis:amplitude=0.2,form=maxwell_slip",
    "viscoelastic:ratio=0.5",
    "quadratic_damping:coefficient=0.01",
    "damping_gradient:slope=1",
    "actuator_lag:time_constant=0.06",
    "actuator_lag:time_constant=0.06,order=second",
    "actuator_lag:time_constant=0.06,order=orifice",
    "dead_time:delay=0.04",
    "torque_bias:bias=0.1",
    "torque_map:quadratic=0.15",
    "torque_decay:decay=0.3",
    "one_sided_cable:lost=0.6",
    "capstan_friction:friction=0.3,conduit=0.1",
    "gravity_tilt:angle=0.2",
    "gravity_tilt:angle=0.2,frame=base",
    "gravity_tilt:angle=0.2,frame=cameras",
    "tip_mass:mass=0.05",
    "added_mass:mass=0.08",
    "marker_offset:offset=0.01",
    *(
        text
        for text in (
            "preset_bend:angle=0.3",
            "partial_bias:bias=0.1,start=0.4",
            "unequal_lag:rise=0.08,fall=0.03,delay=0.01",
            "unequal_lag:rise=0.08,fall=0.03,fills=positive",
            "partial_lag:time_constant=0.06",
            "ringing_drive:period=0.15",
        )
        if text.partition(":")[0] in EFFECTS
    ),
)
TOGETHER = ("torque_map:quadratic=0.15", "actuator_lag:time_constant=0.06", "dead_time:delay=0.02", "torque_bias:bias=0.05")
#: What the cameras make of an arm, and what stands beside it: the export says that it is lost.
LOST = {"length_change", "marker_slip", "camera_scale", "restraint", "side_force"}
#: Obstacles are solids of the file, with MuJoCo's own contact law (``test_solids``).
SOLIDS = {"obstacle"}
#: Those that no element of MuJoCo stands for.
BY_LAW = {
    "partial_lag:time_constant=0.06",
    "ringing_drive:period=0.15",
    "partial_bias:bias=0.1,start=0.4",
    "unequal_lag:rise=0.08,fall=0.03,delay=0.01",
    "unequal_lag:rise=0.08,fall=0.03,fills=positive",
    "actuator_lag:time_constant=0.06,order=second",
    "actuator_lag:time_constant=0.06,order=orifice",
    "bending_stop:ratio=3,angle=0.4,side=positive",
    "stiffening:cubic=2",
    "stiffening:cubic=-0.15",
    "dry_friction:level=0.1,form=load",
    "hysteresis:amplitude=0.2",
    "viscoelastic:ratio=0.5",
    "torque_map:quadratic=0.15",
    "one_sided_cable:lost=0.6",
    "capstan_friction:friction=0.3,conduit=0.1",
}


def model(*effects, **arm):
    return CorrectedModel(ArmSpecification(**arm), tuple(map(parse_effect, effects)))


def test_every_effect_of_the_catalogue_is_tried():
    assert {text.partition(":")[0] for text in EXPRESSED} == set(EFFECTS) - LOST - SOLIDS
    lost = ("length_change:depth=0.01", "marker_slip:slip=0.01", "camera_scale:scale=0.01")
    lost += ("restraint:contact_stiffness=100", "side_force:force=0.1")
    assert {line.partition(":")[0] for text in lost for line in sort(model(text), 4).missing} == LOST


@pytest.mark.parametrize("effect", EXPRESSED)
def test_a_step_and_a_release_are_those_of_hsr_pin(effect, tmp_path):
    gaps = worst_gap(model(effect), tmp_path, quick=True)
    assert max(gaps.values()) < LARGEST, gaps


@pytest.mark.long
@pytest.mark.parametrize(
    ("keq", "damping", "mount", "links", "placement"), [(1.11, 0.05, "hanging", 4, "base"), (2.33, 0.1, "upright", 12, "mid")]
)
@pytest.mark.parametrize("effect", EXPRESSED)
def test_steps_staircase_chirp_and_releases_are_those_of_hsr_pin(effect, keq, damping, mount, links, placement, tmp_path):
    exported = model(effect, links=links, placement=placement, keq=keq, damping=damping, mount=mount)
    gaps = worst_gap(exported, tmp_path, bend=0.8)  # of the torques: what is softened bends beyond its limit
    assert max(gaps.values()) < LARGEST, gaps


@pytest.mark.parametrize(
    "effect", ["", "stiffening:cubic=0.3", "dry_friction:level=0.1", "hysteresis:amplitude=0.2,form=maxwell_slip"]
)
def test_mujoco_3_gets_laws_where_it_lacks_elements(effect, tmp_path):
    told = model(*filter(None, [effect]), placement="mid", mount="upright", links=6)
    exported = to_mjcf(told, major=3)
    assert bool(exported.by_module) == bool(effect)
    for word in ("springyield", "delay="):
        assert word not in exported.text
    assert max(worst_gap(told, tmp_path, quick=True, major=3).values()) < LARGEST


def test_what_the_comparison_would_say_of_a_missing_effect(tmp_path):
    told = model("viscoelastic:ratio=0.5")
    without = replace(told, effects=())
    path = tmp_path / "arm.xml"
    write(to_mjcf(without, laws="arm_laws"), path)
    torque = np.full(60, 0.8)
    bare = motion(path, torque, np.zeros(4))
    write(to_mjcf(told, laws="arm_laws"), path)
    assert 1e3 * np.linalg.norm(motion(path, torque, np.zeros(4)) - bare, axis=2).max() > 10


def test_laws_of_the_command_act_in_their_order(tmp_path):
    assert max(worst_gap(model(*TOGETHER), tmp_path, quick=True).values()) < LARGEST
    assert max(worst_gap(model(*TOGETHER[::-1]), tmp_path, quick=True).values()) < LARGEST


def test_a_gain_of_the_torque_is_the_actuators(tmp_path):
    path = tmp_path / "arm.xml"
    torque = np.full(50, 0.4)
    write(to_mjcf(replace(model(), torque_gain=1.5)), path)
    gained = motion(path, torque, np.zeros(4))
    write(to_mjcf(model()), path)
    assert np.abs(gained - motion(path, 1.5 * torque, np.zeros(4))).max() < 1e-9


@pytest.mark.parametrize("effect", EXPRESSED)
def test_what_has_an_element_needs_no_module(effect):
    exported = to_mjcf(model(effect))
    name = effect.partition(":")[0]
    told = {line.partition(":")[0] for line in (exported.by_module if effect in BY_LAW else exported.held)}
    assert told == {name}
    assert exported.missing == ()


def test_the_module_runs_without_hsr_pin(tmp_path):
    path = tmp_path / "arm.xml"
    write(to_mjcf(model("hysteresis:amplitude=0.2", "torque_map:quadratic=0.15"), laws="arm_laws"), path)
    program = (
        "import sys; sys.modules['hsr_pin'] = None\n"
        "import mujoco, arm_laws\n"
        "model = mujoco.MjModel.from_xml_path('arm.xml')\n"
        "arm_laws.install(model)\n"
        "data = mujoco.MjData(model)\n"
        "data.ctrl[0] = 0.5\n"
        "mujoco.mj_step(model, data, nstep=2000)\n"
        "print(data.site('tip').xpos[0], sorted(n for n in sys.modules if n.partition('.')[0] in ('scipy', 'pinocchio')))"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    place, loaded = done.stdout.split(maxsplit=1)
    assert 0.03 < float(place) < 0.09
    assert loaded == "[]\n"


def test_what_laws_remember_travels_with_the_state(tmp_path):
    path = tmp_path / "arm.xml"
    write(to_mjcf(model("hysteresis:amplitude=0.3"), laws="arm_laws"), path)
    with laws_of(path) as laws:
        arm = mujoco.MjModel.from_xml_path(str(path))
        laws.install(arm)
        first, second = mujoco.MjData(arm), mujoco.MjData(arm)
        first.ctrl[0] = 0.8
        mujoco.mj_step(arm, first, nstep=400)
        state = np.empty(mujoco.mj_stateSize(arm, mujoco.mjtState.mjSTATE_INTEGRATION))
        mujoco.mj_getState(arm, first, state, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_setState(arm, second, state, mujoco.mjtState.mjSTATE_INTEGRATION)
        for data in (first, second):
            mujoco.mj_step(arm, data, nstep=400)
        assert np.array_equal(first.qpos, second.qpos)
        mujoco.mj_resetData(arm, first)
        fresh = mujoco.MjData(arm)
        for data in (first, fresh):
            data.ctrl[0] = 0.3
            mujoco.mj_step(arm, data, nstep=100)
        assert np.array_equal(first.qpos, fresh.qpos)


def test_other_models_are_left_alone_and_other_files_refused(tmp_path):
    path = tmp_path / "arm.xml"
    write(to_mjcf(model("viscoelastic:ratio=0.5"), laws="arm_laws"), path)
    with laws_of(path) as laws:
        arm = mujoco.MjModel.from_xml_path(str(path))
        other = mujoco.MjModel.from_xml_string(to_mjcf(model()).text)
        with pytest.raises(ValueError, match="does not have the mark"):
            laws.install(other)
        laws.install(arm)
        free, held = mujoco.MjData(other), mujoco.MjData(arm)
        for name, data in ((other, free), (arm, held)):
            data.qpos[:] = 0.2
            mujoco.mj_forward(name, data)
        assert np.allclose(free.qfrc_passive, -0.2 * 4.44)
        data = mujoco.MjData(arm)
        mujoco.mj_step(arm, data)
        data.qpos[:] = 0.2
        mujoco.mj_forward(arm, data)
        assert (data.qfrc_passive < free.qfrc_passive - 0.1).all()


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal", "flat"])
def test_the_key_rest_is_where_the_arm_rests(mount):
    exported = to_mjcf(model("torque_bias:bias=0.1", "dry_friction:level=0.02", mount=mount, tip_mass=0.02))
    arm = mujoco.MjModel.from_xml_string(exported.text)
    data = mujoco.MjData(arm)
    mujoco.mj_resetDataKeyframe(arm, data, 0)
    before = data.qpos.copy()
    mujoco.mj_step(arm, data, nstep=4000)
    assert np.abs(before).max() > 0.01
    assert np.abs(data.qpos - before).max() < 1e-4


@pytest.mark.parametrize(("arm", "longest"), [({}, 0.25), ({"links": 100}, 0.25), ({"damping": 0.0, "links": 30}, 0.05)])
def test_the_step_that_is_written_is_stable(arm, longest):
    exported = to_mjcf(model(**arm))
    told = mujoco.MjModel.from_xml_string(exported.text)
    assert 1e3 * told.opt.timestep == pytest.approx(longest)
    assert f"steps of {longest:g} ms" in exported.text
    assert _swung(told) < 2


def test_a_longer_step_than_is_written_would_not_be():
    told = mujoco.MjModel.from_xml_string(to_mjcf(model(damping=0.0, links=30)).text)
    told.opt.timestep *= 3
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        assert _swung(told) == np.inf
    finally:
        mujoco.set_mju_user_warning(None)


def _swung(told):
    """[rad] how far an arm is bent 0.2 s after it was let go; infinite where MuJoCo gave up."""
    data = mujoco.MjData(told)
    data.qpos[:] = 1.0 / told.nv
    while data.time < 0.2 and not data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
        mujoco.mj_step(told, data)
    return np.abs(data.qpos).sum() if data.time >= 0.2 else np.inf


@dataclass(frozen=True)
class Vibrating(Effect):
    """An effect of a user's own."""

    name = "vibrating"
    lacks = "something of one's own"
    cause = "a test"
    citation = "none"
    size: float = amplitude(0.1, "1", lower=0.0, upper=1.0, description="of it")

    @staticmethod
    def moment(p, bending):
        return sys.getrefcount(p) * bending.angle


def test_a_law_that_cannot_be_written_down_is_listed():
    exported = to_mjcf(CorrectedModel(effects=(Vibrating(0.2),)))
    assert exported.module == ""
    assert len(exported.missing) == 1
    assert exported.missing[0].startswith("vibrating: ")
    assert "a law that uses sys" in exported.missing[0]
    assert f"Not in it: {exported.missing[0]}" in exported.text


def test_a_damper_that_mujoco_3_lacks_is_listed():
    assert "quadratic_damping" in to_mjcf(model("quadratic_damping:coefficient=0.01"), major=3).missing[0]
    assert "dead_time" in to_mjcf(model("dead_time:delay=0.02"), major=3).missing[0]


def test_versions_that_are_not_known_and_names_that_make_no_module_are_refused(tmp_path):
    with pytest.raises(InputError, match="version of MuJoCo: expected 3 or 4, got 2"):
        to_mjcf(model(), major=2)
    with pytest.raises(OutputError, match="letters, digits and _"):
        write(to_mjcf(model("viscoelastic:ratio=0.5")), tmp_path / "my-arm.xml")
    assert list(tmp_path.iterdir()) == []
    assert importlib.util.find_spec("arm_laws") is None


@pytest.mark.parametrize("placement", ["base", "mid", "shifted"])
def test_the_mass_matrix_of_the_straight_arm_is_pinocchios(placement):
    arm = ArmSpecification(links=7, placement=placement, tip_mass=0.02)
    model = build_model(arm).model
    upper = np.triu(pin.crba(model, model.createData(), np.zeros(7)))
    np.testing.assert_allclose(mass_matrix(chain_of(Arms.of([arm]))), upper + np.triu(upper, 1).T, rtol=1e-12)
