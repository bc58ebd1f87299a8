"""The URDF is the arm: every reader sees the same bodies, and the file alone gives the specification back."""

import io
import itertools
import logging
import math
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr_pin.errors import OutputError, UrdfError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import arm_to_urdf, load_urdf, save_urdf, urdf_to_arm

ARMS = [
    ArmSpecification(links=links, placement=placement, mount=mount, tilt=tilt, tip_mass=tip_mass)
    for links, placement, mount, (tilt, tip_mass) in itertools.product(
        (1, 4, 5), ("base", "mid"), ("hanging", "upright", "horizontal", "flat"), ((0.0, 0.0), (-0.4, 0.03))
    )
]


def label(arm):
    return f"{arm.links}-{arm.placement}-{arm.mount}-{arm.tilt}-{arm.tip_mass}"


def positive(top):
    return st.floats(1e-4, top)


SPECIFICATIONS = st.builds(
    ArmSpecification,
    links=st.integers(1, 20),
    keq=positive(100.0),
    damping=st.floats(0.0, 10.0),
    placement=st.sampled_from(["base", "mid"]),
    mount=st.sampled_from(["hanging", "upright", "horizontal", "flat"]),
    length=positive(3.0),
    mass=positive(10.0),
    diameter=positive(0.5),
    tip_mass=st.floats(0.0, 1.0),
    tilt=st.floats(-math.pi, math.pi),
    bending_limit=positive(10.0),
)


def in_pinocchio(arm):
    model = pin.buildModelFromXML(arm_to_urdf(arm))
    return model, model.createData()


def in_yourdfpy(arm, scene=True):
    return yourdfpy.URDF.load(io.BytesIO(arm_to_urdf(arm).encode()), build_scene_graph=scene)


def rotation(arm):
    """Base to world, written out by hand: columns are local x, y, z."""
    mount = {
        "upright": np.eye(3),
        "hanging": np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
        "horizontal": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
        "flat": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    }[arm.mount]
    c, s = math.cos(arm.tilt), math.sin(arm.tilt)
    return mount @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def backbone(arm, q, arc_length):
    """(3,) [m] a point of the chain, by walking along it in the plane."""
    joints = arm.joint_arc_lengths * arm.length
    knots = [0.0, *joints[(joints > 0) & (joints < arc_length)], arc_length]
    point = np.zeros(2)
    for start, end in itertools.pairwise(knots):
        angle = q[joints <= (start + end) / 2].sum()
        point += (end - start) * np.array([math.sin(angle), math.cos(angle)])
    return rotation(arm) @ [point[0], 0.0, point[1]]


@pytest.fixture(autouse=True)
def silence(caplog):
    """A reader that complains, in a warning or in its log, has not been given a good URDF."""
    yield
    assert [record.message for record in caplog.records if record.levelno >= logging.WARNING] == []


@pytest.mark.parametrize("arm", ARMS, ids=label)
def test_pinocchio_and_yourdfpy_and_our_own_walk_find_the_same_points(arm):
    (model, data), urdf = in_pinocchio(arm), in_yourdfpy(arm)
    assert urdf.validate(), urdf.errors
    assert model.nq == model.nv == arm.links
    rng = np.random.default_rng(arm.links)
    for q in rng.uniform(-1.5, 1.5, (3, arm.links)):
        pin.framesForwardKinematics(model, data, q)
        urdf.update_cfg(q)
        for frame, arc_length in (("base", 0.0), ("middle", arm.length / 2), ("tip", arm.length)):
            pose = data.oMf[model.getFrameId(frame)].homogeneous
            np.testing.assert_allclose(pose[:3, 3], backbone(arm, q, arc_length), atol=1e-12)
            np.testing.assert_allclose(urdf.get_transform(frame, "world"), pose, atol=1e-12)


@pytest.mark.parametrize("arm", ARMS, ids=label)
def test_pinocchio_and_yourdfpy_have_the_same_bodies(arm):
    (model, _), urdf = in_pinocchio(arm), in_yourdfpy(arm, scene=False)
    bodies = {link.name: link.inertial for link in urdf.robot.links if link.inertial is not None}
    payload = bodies.pop("tip", None)
    assert (payload.mass if payload else 0.0) == arm.tip_mass
    assert list(bodies) == [f"link_{i}" for i in range(0 if arm.placement == "mid" else 1, arm.links + 1)]
    for name, body in bodies.items():
        expected = pin.Inertia(body.mass, body.origin[:3, 3], body.inertia)
        if payload and name == f"link_{arm.links}":
            expected += pin.Inertia(payload.mass, 2 * body.origin[:3, 3], payload.inertia)
        number = int(name.removeprefix("link_"))
        found = model.inertias[number] if number else pin.SE3(rotation(arm).T, np.zeros(3)).act(model.inertias[0])
        np.testing.assert_allclose(found.toDynamicParameters(), expected.toDynamicParameters(), rtol=1e-12, atol=1e-18)
    assert urdf.actuated_joint_names == list(model.names)[1:] == [f"joint_{i + 1}" for i in range(arm.links)]


@pytest.mark.parametrize("arm", ARMS, ids=label)
def test_the_straight_arm_is_one_uniform_cylinder_and_its_payload(arm):
    model, data = in_pinocchio(arm)
    pin.forwardKinematics(model, data, pin.neutral(model))
    whole = sum((data.oMi[i].act(model.inertias[i]) for i in range(1, model.njoints)), start=model.inertias[0])
    m, r, L = arm.mass, arm.diameter / 2, arm.length
    across = m * (3 * r**2 + L**2) / 12 + m * (L / 2) ** 2 + arm.tip_mass * L**2
    R = rotation(arm)
    at_base = R @ np.diag([across, across, m * r**2 / 2]) @ R.T
    centre = (m * L / 2 + arm.tip_mass * L) / (m + arm.tip_mass) * R[:, 2]
    assert whole.mass == pytest.approx(m + arm.tip_mass, rel=1e-12)
    np.testing.assert_allclose(whole.lever, centre, atol=1e-12)
    lever = pin.skew(whole.lever)
    np.testing.assert_allclose(whole.inertia - whole.mass * lever @ lever, at_base, atol=1e-12)


@pytest.mark.parametrize(
    ("mount", "direction", "towards"),
    [
        ("hanging", [0, 0, -1], [1, 0, 0]),
        ("upright", [0, 0, 1], [1, 0, 0]),
        ("horizontal", [1, 0, 0], [0, 0, -1]),
        ("flat", [1, 0, 0], [0, 0, -1]),
    ],
)
@pytest.mark.parametrize("placement", ["base", "mid"])
def test_the_arm_points_where_its_mount_says_and_bends_and_tilts_to_the_positive_side(mount, direction, towards, placement):
    arm = ArmSpecification(mount=mount, placement=placement)

    def tip(arm, q):
        model, data = in_pinocchio(arm)
        pin.framesForwardKinematics(model, data, np.full(4, q))
        return data.oMf[model.getFrameId("tip")].translation.copy()

    np.testing.assert_allclose(tip(arm, 0.0), 0.24 * np.array(direction), atol=1e-12)
    assert tip(arm, 0.1) @ towards > 0.04
    assert tip(replace(arm, tilt=0.2), 0.0) @ towards == pytest.approx(0.24 * math.sin(0.2))


def test_joints_are_revolute_and_turn_as_far_as_the_whole_arm_may():
    model, _ = in_pinocchio(ArmSpecification(bending_limit=2.5))
    assert {joint.shortname() for joint in list(model.joints)[1:]} == {"JointModelRY"}
    np.testing.assert_array_equal(model.upperPositionLimit, np.full(4, 2.5))
    np.testing.assert_array_equal(model.lowerPositionLimit, np.full(4, -2.5))


@pytest.mark.parametrize("links", [4, 65])
def test_the_drawn_arm_is_as_long_and_thick_as_the_real_one(links):
    scene = in_yourdfpy(ArmSpecification(links=links, mount="upright")).scene
    names = [node for node in scene.graph.nodes_geometry if scene.geometry[scene.graph[node][1]].visual.main_color[2] < 200]
    corners = np.concatenate([corners_of(scene, node) for node in names])
    np.testing.assert_allclose(np.ptp(corners, axis=0), [0.04, 0.04, 0.24], atol=2e-4)


def corners_of(scene, node):
    transform, geometry = scene.graph[node]
    vertices = scene.geometry[geometry].vertices
    return vertices @ transform[:3, :3].T + transform[:3, 3]


def test_every_link_has_a_colour_of_its_own():
    materials = {
        material.name: tuple(material.color.rgba)
        for material in in_yourdfpy(ArmSpecification(links=16), scene=False).robot.materials
    }
    assert len({materials[f"link_{i}"] for i in range(1, 17)}) == 16


@settings(max_examples=60, deadline=None)
@given(SPECIFICATIONS)
def test_reading_what_was_written_gives_the_identical_arm(arm):
    assert urdf_to_arm(arm_to_urdf(arm)) == arm


def test_numbers_of_numpy_are_written_like_any_other():
    arm = ArmSpecification(links=np.int64(3), keq=np.float64(1.1), mass=np.float32(0.1), length=1)
    assert urdf_to_arm(arm_to_urdf(arm)) == arm
    assert "np." not in arm_to_urdf(arm)


def test_the_file_says_the_stiffness_and_damping_of_each_joint():
    assert 'joint_stiffness="4.44" joint_damping="0.2"/>' in arm_to_urdf(ArmSpecification())


def test_a_saved_file_is_loaded_as_it_was_and_replaces_what_was_there(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text("old")
    arm = ArmSpecification(links=7, keq=2.33)
    save_urdf(arm, path)
    assert load_urdf(path) == arm
    assert list(tmp_path.iterdir()) == [path]


def test_looks_comments_and_spacing_are_free_to_change():
    text = arm_to_urdf(ArmSpecification())
    changed = re.sub(r"<color rgba=\"[^\"]*\"", '<color rgba="1 0 0 1"', text).replace("\n  <link", "\n<!-- mine -->\n\n<link")
    changed = re.sub(r"\s*<visual>.*?</visual>", "", changed, flags=re.DOTALL)
    assert changed != text
    assert urdf_to_arm(changed) == ArmSpecification()


GOOD = arm_to_urdf(ArmSpecification())
MASS = '<mass value="0.0375"/>'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", r"a\.urdf:1:\d+: not XML: expected a complete URDF file, got no element found"),
        ("links = 4", r"a\.urdf:1:1: not XML"),
        (
            GOOD[: len(GOOD) // 2],
            r"a\.urdf:\d+:\d+: not XML: expected a complete URDF file, got .*; write a new one with hsr-urdf",
        ),
        ("<html></html>", r"a\.urdf:1:1: not a URDF: expected <robot> around everything, got <html>"),
        ('<robot name="r"><link name="l"/></robot>', r"a\.urdf:1:1: not a URDF of hsr_pin: expected one <hsr> .*, got none"),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot>&a;</robot>', r"a\.urdf:1:1\d*: a document type declaration"),
        (GOOD.replace("<material", '<hsr version="1"/><material', 1), r"a\.urdf:4:1: .*one <hsr> element under <robot>, got 2"),
        (
            GOOD.replace('version="1" links', 'version="9" links'),
            r"a\.urdf:5:3: <hsr>: expected version=\"1\" or version=\"2\", got '9'",
        ),
        (GOOD.replace(' keq="1.11"', ""), r"a\.urdf:5:3: <hsr>: expected an attribute keq, got none"),
        (GOOD.replace('keq="1.11"', 'keq="-1"'), r"a\.urdf:5:3: <hsr> keq: expected a number, more than zero .*, got -1\.0"),
        (GOOD.replace('keq="1.11"', 'keq="nan"'), r"a\.urdf:5:3: <hsr> keq: .*got nan"),
        (GOOD.replace('keq="1.11"', 'keq="soft"'), r"a\.urdf:5:3: <hsr> keq: .*got 'soft'"),
        (GOOD.replace('links="4"', 'links="2.5"'), r"a\.urdf:5:3: <hsr> links: expected a whole number .*, got '2\.5'"),
        (GOOD.replace('mount="hanging"', 'mount="up"'), r"a\.urdf:5:3: <hsr> mount: expected hanging or upright .*, got 'up'"),
        (
            GOOD.replace('links="4"', 'links="5"'),
            r"a\.urdf:\d+:\d+: .* does not fit the arm in <hsr>: expected .*; change the arm with hsr-urdf",
        ),
        (GOOD.replace('links="4"', 'links="3"'), r"a\.urdf:\d+:\d+: .* does not fit the arm in <hsr>"),
        (
            GOOD.replace(' mass="0.15"', ' mass="0.16"'),
            r"link link_1 inertial mass value does not fit the arm in <hsr>: expected 0\.04, got 0\.0375",
        ),
        (GOOD.replace(MASS, '<mass value="0.05"/>', 1), r"link link_1 inertial mass value .*expected 0\.0375, got 0\.05"),
        (GOOD.replace(MASS, MASS + MASS, 1), r"link link_1 inertial mass \(again\) "),
        (GOOD.replace('rpy="3.14', 'rpy="3.15', 1), r"joint world_to_base origin rpy does not fit"),
        (
            GOOD.replace('"revolute"', '"continuous"', 1),
            r"joint joint_1 type does not fit the arm in <hsr>: expected revolute, got continuous",
        ),
        (GOOD.replace('<axis xyz="0 1 0"/>', "", 1), r"joint joint_1 axis does not fit .*: expected <axis>, got nothing"),
        (GOOD.replace("</robot>", '<link name="extra"/></robot>'), r"link extra .*expected nothing"),
    ],
)
def test_a_file_that_is_not_ours_or_was_changed_is_one_clear_line(tmp_path, text, said):
    path = tmp_path / "a.urdf"
    path.write_text(text)
    with pytest.raises(UrdfError, match=said) as caught:
        load_urdf(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    assert caught.value.line is not None


def test_no_number_of_the_file_can_be_changed_unnoticed():
    """Nudge each number outside of the visuals, one at a time: refused, or the arm that comes back says so."""
    bare = re.sub(
        r"\s*<(visual|material)\b.*?</\1>", "", arm_to_urdf(ArmSpecification(links=2, placement="mid")), flags=re.DOTALL
    )
    body = bare.index("<hsr")
    numbers = [match for match in re.finditer(r'(?<=[" ])-?\d+(\.\d+)?(e-?\d+)?(?=[" ])', bare) if match.start() > body]
    assert len(numbers) > 80
    unnoticed = []
    for match in numbers:
        nudged = bare[: match.start()] + repr(float(match.group()) + 0.01) + bare[match.end() :]
        try:
            if urdf_to_arm(nudged) == urdf_to_arm(bare):
                unnoticed.append(bare[match.start() - 30 : match.end() + 5])
        except UrdfError:
            pass
    assert unnoticed == []


def test_the_urdf_of_another_robot_is_refused():
    root = Path(pin.__file__).resolve()
    folder = next(parent for parent in root.parents if (parent / "share" / "example-robot-data").is_dir())
    path = folder / "share/example-robot-data/robots/double_pendulum_description/urdf/double_pendulum.urdf"
    with pytest.raises(UrdfError, match="not a URDF of hsr_pin"):
        load_urdf(path)


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00"])
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    path = tmp_path / "a.urdf"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UrdfError, match=r"a\.urdf: cannot read the file: expected a URDF written by hsr-urdf, got "):
        load_urdf(path)


def test_a_file_that_cannot_be_written_is_named_and_nothing_is_left(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match=r"arm\.urdf: cannot write the file: .*got Not a directory"):
        save_urdf(ArmSpecification(), tmp_path / "file" / "arm.urdf")
    with pytest.raises(OutputError, match="got Is a directory"):
        save_urdf(ArmSpecification(), tmp_path)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("file", "mine")]


def test_every_quantity_of_the_specification_is_in_the_file():
    of_space = {"bending", "torsion", "cross_tilt"}
    names = {field.name for field in fields(ArmSpecification)} - {"sections", "obstacles"}
    for text, wanted in ((GOOD, names - of_space), (arm_to_urdf(ArmSpecification(bending="space")), names)):
        attributes = re.search(r"<hsr ([^>]*)/>", text).group(1)
        assert wanted <= set(re.findall(r"(\w+)=", attributes))
