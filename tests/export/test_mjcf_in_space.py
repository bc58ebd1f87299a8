"""Exported MJCF of arms in space moves in MuJoCo as the model does in hsr_pin: to 0.5 mm from 10 links on, for every law."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.export import command
from hsr_pin.effects import parse_effect
from hsr_pin.effects.catalogue import laws
from hsr_pin.effects.effect import neutral, unsupported_laws
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.export.document import read_result
from hsr_pin.export.mjcf import to_mjcf
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.parts import sort
from hsr_pin.export.plain import ENOUGH
from hsr_pin.identification.document import to_json
from hsr_pin.identification.identify import identify
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Marker, Section, Trial

from .in_mujoco_in_space import motion, worst_gap

mujoco = pytest.importorskip("mujoco")
if mujoco.mj_version() < 4000000:
    pytest.skip("needs MuJoCo 4, which needs Python 3.11", allow_module_level=True)

#: The border between them is within a link.
UNEVEN = (Section(0.14, 0.10, 1.6, 0.09), Section(0.10, 0.05, 1.4, 0.06))
#: [mm] as in a plane.
LARGEST = 0.5
NATIVE = (
    "stiffness_gradient:slope=0.6",
    "damping_gradient:slope=1",
    "soft_spot:depth=0.6",
    "unequal_stiffness:along_x=0.3,diagonal=-0.2",
    "bend_at_rest:towards_x=0.2,towards_y=-0.3",
    "torsion_compliance:ratio=1.3",
    "turned_actuation:angle=0.5",
    "torque_offset:towards_x=0.1,towards_y=-0.2",
    "actuator_lag:time_constant=0.06",
    "dead_time:delay=0.04",
    "torque_decay:decay=0.3",
    "base_tilt:towards_x=0.2,towards_y=-0.15",
    "base_tilt:towards_x=0.2,towards_y=-0.15,frame=base",
    "base_tilt:towards_x=0.2,towards_y=-0.15,frame=cameras",
    "tip_mass:mass=0.05",
    "added_mass:mass=0.08",
    "markers_beside:towards_x=0.01,towards_y=-0.02",
)
BY_LAW = (
    "stiffening:cubic=0.3",
    "bending_stop:ratio=3,angle=0.6",
    "backlash:gap=0.2",
    "dry_friction:level=0.1",
    "hysteresis:amplitude=0.2",
    "hysteresis:amplitude=0.2,form=maxwell_slip",
    "viscoelastic:ratio=0.5",
    "torque_map:quadratic=0.15",
    "unequal_lag:rise=0.08,fall=0.03,delay=0.01",
    "partial_lag:time_constant=0.06",
    "ringing_drive:period=0.15",
    "weak_chamber:loss=0.4,direction=0.7",
)
#: What the cameras make of an arm, and a damper that no hinge has: the export says that it is lost.
LOST = (
    "length_change:depth=0.01",
    "marker_slip:slip=0.01",
    "camera_scale:scale=0.01",
    "quadratic_damping:coefficient=0.01",
    "markers_beside:towards_x=0.01,base=zeroed",
)


def model(*effects, markers=(), **arm):
    told = {"links": ENOUGH, "placement": "mid", "bending": "space", "torsion": 1.11, **arm}
    return CorrectedModel(ArmSpecification(**told), tuple(map(parse_effect, effects)), markers=markers)


def test_every_law_of_an_arm_in_space_is_tried():
    tried = {text.partition(":")[0] for text in (*NATIVE, *BY_LAW, *LOST)}
    assert tried == {
        law.name for law in laws(space=True) if not unsupported_laws([neutral(law)], space=True) and not law.flexible
    }
    assert set(SPATIAL) <= tried
    for text in LOST:
        assert text.partition(":")[0] in {line.partition(":")[0] for line in sort(model(text), 4).missing}


@pytest.mark.parametrize("effect", ["", *NATIVE, *(pytest.param(each, marks=pytest.mark.long) for each in BY_LAW)])
def test_rounds_and_releases_are_those_of_hsr_pin(effect, tmp_path):
    gaps = worst_gap(model(*filter(None, [effect])), tmp_path, names=("round", "release"))
    assert max(gaps.values()) < LARGEST, gaps


@pytest.mark.long
@pytest.mark.parametrize(
    "arm", [{"torsion": np.inf, "mount": "upright", "links": 16}, {"mount": "horizontal", "keq": 2.33, "damping": 0.1}]
)
@pytest.mark.parametrize("effect", ["", *NATIVE, *BY_LAW])
def test_so_they_are_of_other_arms(effect, arm, tmp_path):
    gaps = worst_gap(model(*filter(None, [effect]), **arm), tmp_path, names=("round", "step", "release", "release of a couple"))
    assert max(gaps.values()) < LARGEST, gaps


@pytest.mark.parametrize(
    "effects",
    [
        ("turned_actuation:angle=0.5", "torque_offset:towards_x=0.1,towards_y=-0.2", "actuator_lag:time_constant=0.06"),
        ("torque_offset:towards_x=0.1,towards_y=-0.2", "turned_actuation:angle=0.5", "dead_time:delay=0.02"),
        ("turned_actuation:angle=0.5", "weak_chamber:loss=0.4,direction=0.7", "actuator_lag:time_constant=0.06"),
        ("unequal_stiffness:along_x=-0.2,diagonal=0.2", "bend_at_rest:towards_x=0.2,towards_y=-0.3"),
    ],
)
def test_laws_act_together_and_in_their_order(effects, tmp_path):
    gaps = worst_gap(model(*effects), tmp_path, names=("round", "release of a couple"))
    assert max(gaps.values()) < LARGEST, gaps


def test_markers_beside_the_backbone_and_sections_are_where_they_are(tmp_path):
    markers = (Marker("base", 0.0), Marker("mid", 0.1, 0.03, 1.0), Marker("tip", 0.2, 0.02, -2.0))
    arm = ArmSpecification.in_sections(
        [Section(0.1, 0.09, 3.0, 0.2), Section(0.1, 0.05, 1.5, 0.1)], links=ENOUGH, placement="mid", torsion=1.0
    )
    for effects in ((), ("weak_chamber:loss=0.4",)):
        told = CorrectedModel(arm, tuple(map(parse_effect, effects)), markers=markers)
        assert to_mjcf(told).text.count("<general ") == 4
        gaps = worst_gap(told, tmp_path, names=("round", "release of a couple"))
        assert max(gaps.values()) < LARGEST, gaps


@pytest.mark.parametrize(
    "effects",
    [
        ("stiffness_gradient:slope=0.6", "damping_gradient:slope=1"),
        ("unequal_stiffness:along_x=0.3,diagonal=-0.2", "bend_at_rest:towards_x=0.2,towards_y=-0.3"),
        ("turned_actuation:angle=0.5", "torque_offset:towards_x=0.1,towards_y=-0.2", "actuator_lag:time_constant=0.06"),
        ("torque_decay:decay=0.3", "dead_time:delay=0.04"),
        ("stiffening:cubic=0.3", "dry_friction:level=0.1"),
        ("unequal_lag:rise=0.08,fall=0.03,delay=0.01", "tip_mass:mass=0.05"),
    ],
)
@pytest.mark.long
def test_laws_act_in_sections_as_they_do_in_hsr_pin(effects, tmp_path):
    arm = ArmSpecification.in_sections(UNEVEN, links=ENOUGH, placement="mid", torsion=1.0, mount="upright", tip_mass=0.01)
    gaps = worst_gap(CorrectedModel(arm, tuple(map(parse_effect, effects))), tmp_path, names=("round", "release of a couple"))
    assert max(gaps.values()) < LARGEST, gaps


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """What hsr-fit writes of recordings of an arm of two sections, that is declared softer than it is; and the arm."""
    arm = ArmSpecification.in_sections(UNEVEN, links=ENOUGH, placement="mid", bending_limit=20.0)
    time = np.arange(81) * 0.01
    torque = (time[:, None] >= 0.1 - 1e-9) * np.array([0.6, 0.2, -0.5, 0.3])
    markers = (Marker("mid", 0.14), Marker("tip", 0.24), Marker("side", 0.24, 0.03, 0.7))
    seen = simulate(Scenario(arm, time, torque, Settled(0.0), (), markers)).trajectory
    noise = 1e-4 * np.random.default_rng(2).normal(size=seen.positions.shape)
    motion = replace(seen, positions=seen.positions + noise, joint_angles=None, joint_rates=None)
    trial = Trial("trial_01", motion, arm.keq / 1.3, arm.damping)
    numbers = {name: getattr(arm, name) for name in ("length", "mass", "diameter", "mount", "bending")}
    dataset = Dataset("two", trials=(trial,), sections=UNEVEN, **numbers)
    path = tmp_path_factory.mktemp("fitted") / "fit.json"
    path.write_text(json.dumps(to_json(identify(dataset, free=["keq", "damping"], links=ENOUGH))), encoding="utf-8")
    return path, arm, dataset


def test_a_fit_of_an_arm_of_sections_moves_in_mujoco_as_it_was_recorded(fitted, tmp_path):
    path, arm, dataset = fitted
    output = tmp_path / "arm.xml"
    assert run(command, ["--from", str(path), "--to", "mjcf", "-o", str(output)]) == 0
    told = read_result(path)
    assert told.arm.sections == UNEVEN
    assert told.arm.keq == pytest.approx(arm.keq, rel=0.01)
    recorded = dataset.trials[0].trajectory
    names = [marker.name for marker in dataset.markers]
    theirs = motion(output, recorded.torque, np.zeros((ENOUGH, 3)), markers=names)
    assert 1e3 * np.sqrt(np.mean(np.sum((theirs - recorded.positions) ** 2, axis=2))) < LARGEST


@pytest.mark.parametrize("target", ["urdf", "sdf"])
def test_where_a_format_has_no_actuators_the_share_of_each_section_is_told(fitted, target, tmp_path, capsys):
    assert run(command, ["--from", str(fitted[0]), "--to", target, "-o", str(tmp_path / "arm.xml")]) == 0
    assert "shares at the joints from base to tip: of section 1 1, 1, 1, 1, 1, 0.833333, 0," in capsys.readouterr().out


def test_in_one_order_throughout_the_hinges_would_not_do(tmp_path, monkeypatch):
    monkeypatch.setattr("hsr_pin.export.bodies._in_order", lambda ways, joint: ways)
    assert worst_gap(model(), tmp_path, names=("round",))["round"] > 2 * LARGEST


def test_few_links_are_said_to_be_few(tmp_path):
    told = model(links=4)
    assert "4 links are few; use 10 or more" in to_mjcf(told).missing[0]
    assert worst_gap(told, tmp_path, names=("round",))["round"] > LARGEST


def test_mujoco_3_moves_it_alike(tmp_path):
    told = model("unequal_stiffness:along_x=0.3", "dry_friction:level=0.1")
    assert "springyield" not in to_mjcf(told, major=3).text
    assert max(worst_gap(told, tmp_path, major=3, names=("round",)).values()) < LARGEST


@pytest.mark.parametrize("mount", ["hanging", "horizontal"])
def test_the_key_rest_is_where_the_arm_rests(mount):
    exported = to_mjcf(model("torque_offset:towards_x=0.1,towards_y=0.2", "base_tilt:towards_y=0.2", mount=mount))
    arm = mujoco.MjModel.from_xml_string(exported.text)
    data = mujoco.MjData(arm)
    mujoco.mj_resetDataKeyframe(arm, data, 0)
    mujoco.mj_forward(arm, data)
    before = data.site("tip").xpos.copy()
    mujoco.mj_step(arm, data, nstep=4000)
    assert np.hypot(*data.qpos.reshape(-1, 3)[::2, :2].sum(axis=0)) > 0.05
    assert 1e3 * np.linalg.norm(data.site("tip").xpos - before) < LARGEST


def test_an_arm_that_hardly_resists_twisting_is_stable_at_the_step_that_is_written():
    told = mujoco.MjModel.from_xml_string(to_mjcf(model(damping=0.0, links=20, torsion=50.0)).text)
    slow = mujoco.MjModel.from_xml_string(to_mjcf(model(damping=0.0, links=20, torsion=np.inf)).text)
    assert told.opt.timestep < slow.opt.timestep
    data = mujoco.MjData(told)
    data.qpos[:] = 1.0 / told.nv
    mujoco.mj_step(told, data, nstep=round(0.1 / told.opt.timestep))
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number == 0
    assert np.abs(data.qpos).max() < 1.0


@pytest.mark.parametrize("effect", ["", *NATIVE, *BY_LAW])
def test_what_has_an_element_needs_no_module(effect):
    exported = to_mjcf(model(*filter(None, [effect])))
    name = effect.partition(":")[0]
    assert {line.partition(":")[0] for line in (exported.by_module if effect in BY_LAW else exported.held)} == set(
        filter(None, [name])
    )
    assert bool(exported.module) == (effect in BY_LAW)
    assert [line.partition(":")[0] for line in exported.missing] == ["joints"]
    for line in exported.missing:
        assert f"Not in it: {line}" in exported.text
