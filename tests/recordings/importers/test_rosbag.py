"""Bags of ROS 1 and 2, written here with the library that reads them, give their points and pressures."""

import numpy as np
import pytest

from hsr_pin.errors import MissingDependencyError, RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.detect import read_capture
from hsr_pin.recordings.importers.mapping import read_mapping
from hsr_pin.recordings.importers.settings import ImportSettings

pytest.importorskip("rosbags", reason="needs rosbags (group ros)")

START = 1_700_000_000_123_456_789  # ns


def headers(types, second):
    stamp = START + round(1e9 * second)
    time = types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
    kind = types["std_msgs/msg/Header"]
    more = {"seq": 0} if "seq" in kind.__dataclass_fields__ else {}
    return stamp, kind(stamp=time, frame_id="world", **more)


def quaternion(types):
    return types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)


def write_bag(path, lab, version):
    """The base as poses, the middle as markers of an array, the tip as points half a sample later, pressures at 10 Hz."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    types = store.types
    writer = Writer1(path) if version == 1 else Writer2(path, version=8)
    serialize = store.serialize_ros1 if version == 1 else store.serialize_cdr
    point = types["geometry_msgs/msg/Point"]
    pose = types["geometry_msgs/msg/Pose"]
    marker = types["visualization_msgs/msg/Marker"]
    with writer:
        kinds = {
            "/base": "geometry_msgs/msg/PoseStamped",
            "/markers": "visualization_msgs/msg/MarkerArray",
            "/tip": "geometry_msgs/msg/PointStamped",
            "/pressures": "std_msgs/msg/Float64MultiArray",
        }
        topics = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}

        def put(topic, at, message):
            writer.write(topics[topic], at, serialize(message, kinds[topic]))

        for n, t in enumerate(lab.time):
            at, header = headers(types, t)
            places = lab.positions[n]
            put("/base", at, types[kinds["/base"]](header, pose(point(*places[0]), quaternion(types))))
            put(
                "/markers",
                at,
                types[kinds["/markers"]]([blank_marker(types, marker, header, pose(point(*places[1]), quaternion(types)))]),
            )
            at, header = headers(types, t + 0.5 / lab.rate)
            after = lab.positions[min(n + 1, len(lab.time) - 1)]
            put("/tip", at, types[kinds["/tip"]](header, point(*(0.5 * (places[2] + after[2])))))
            if n % 12 == 0:
                layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
                values = np.array([120.0, 120.0 + 50 * lab.torque[n]])
                put("/pressures", headers(types, t)[0], types[kinds["/pressures"]](layout, values))


def blank_marker(types, marker, header, pose):
    """A marker with what it must have."""
    values = {}
    for name, (kind, detail) in ((field.name, (0, 0)) for field in marker.__dataclass_fields__.values()):
        del kind, detail
        values[name] = 0
    zero = types["builtin_interfaces/msg/Duration"](sec=0, nanosec=0)
    color = types["std_msgs/msg/ColorRGBA"](r=0.0, g=0.0, b=0.0, a=1.0)
    values |= {"header": header, "pose": pose, "ns": "mid", "scale": types["geometry_msgs/msg/Vector3"](1.0, 1.0, 1.0)}
    values |= {"color": color, "lifetime": zero, "frame_locked": False, "points": [], "colors": [], "text": ""}
    values |= {"mesh_resource": "", "mesh_use_embedded_materials": False}
    if "texture_resource" in values:
        image = types["sensor_msgs/msg/CompressedImage"](header=header, format="", data=np.zeros(0, dtype=np.uint8))
        values |= {"texture_resource": "", "texture": image, "uv_coordinates": []}
        values["mesh_file"] = types["visualization_msgs/msg/MeshFile"](filename="", data=np.zeros(0, dtype=np.uint8))
    return marker(**values)


@pytest.fixture(params=[1, 2], ids=["ROS 1", "ROS 2"])
def bag(request, tmp_path, laboratory):
    lab = laboratory(seconds=2.0)
    path = tmp_path / ("run.bag" if request.param == 1 else "run")
    write_bag(path, lab, request.param)
    return path, lab


def test_points_come_back_on_one_clock(bag):
    path, lab = bag
    capture = read_capture(path)
    assert set(capture.names) == {"/base", "/markers/mid0", "/tip"}
    assert (capture.system, capture.unit, capture.up.axis) == ("ROS bag", "m", None)
    assert capture.start == pytest.approx(START / 1e9)
    found = capture.positions[:, [capture.names.index(name) for name in ("/base", "/markers/mid0", "/tip")]]
    assert np.abs(capture.time - lab.time).max() < 1e-6
    assert np.abs(found[:, :2] - lab.positions[:, :2]).max() < 1e-9
    smooth = np.abs(found[2:-2, 2] - lab.positions[2:-2, 2]).max()
    assert smooth < 3e-3  # a straight line over a sample of a step
    assert np.isnan(found[0, 2]).all()  # the tip was not seen yet


def test_pressures_of_the_same_bag_become_the_input(bag, tmp_path):
    path, lab = bag
    (tmp_path / "map.toml").write_text(
        '[input]\nP1 = "/pressures:data[0]"\nP2 = "/pressures:data[1]"\nunit = "kPa"\n', encoding="utf-8"
    )
    bodies = (Body("base", ("/base",), 0.0), Body("mid", ("/markers/mid0",), 0.12), Body("tip", ("/tip",), 0.24))
    given = {"mass": 0.15, "diameter": 0.04, "keq": [1.11], "markers": bodies, "mount": "hanging"}
    made = import_recordings([path], ImportSettings(**given, mapping=read_mapping(tmp_path / "map.toml")))
    trajectory = made.dataset.trials[0].trajectory
    held = np.repeat(lab.torque[::12], 12)[: len(trajectory.time)]
    assert np.allclose(trajectory.pressures, np.stack([1.2 + 0 * held, 1.2 + 0.5 * held], axis=1))
    assert np.nanmax(np.abs(trajectory.positions[5:-5, :2] - lab.world[5 : len(trajectory.time) - 5, :2])) < 1e-3


@pytest.mark.parametrize(
    "field, said",
    [("/pressure:data[0]", "did you mean '/pressures'?"), ("/pressures:data[7]", "no field"), ("/pressures:values", "no field")],
)
def test_a_topic_or_field_that_is_not_there_is_named(bag, tmp_path, field, said):
    (tmp_path / "map.toml").write_text(f'[input]\ntau = "{field}"\n', encoding="utf-8")
    given = {"mass": 0.15, "diameter": 0.04, "keq": [1.11], "mount": "hanging", "markers": [Body("base", ("/base",), 0.0)]}
    with pytest.raises(RecordingError, match=said.replace("?", r"\?")):
        import_recordings([bag[0]], ImportSettings(**given, mapping=read_mapping(tmp_path / "map.toml")))


FIELDS = """\
[space]
up = "+z"
[points]
base = ["/base:pose.position.x", "/base:pose.position.y", "/base:pose.position.z"]
mid = ["/markers:markers[ns=mid].pose.position.x", "-/markers:markers[ns=mid].pose.position.z", ""]
tip = ["/tip:point.x", "/tip:point.y", "/tip:point.z"]
"""


def test_a_mapping_names_the_fields_of_any_messages(bag, tmp_path):
    path, lab = bag
    (tmp_path / "map.toml").write_text(FIELDS, encoding="utf-8")
    named, plain = read_capture(path, None, read_mapping(tmp_path / "map.toml")), read_capture(path)
    assert named.names == ("base", "mid", "tip")
    assert (named.up.axis, named.start) == ("+z", plain.start)
    found = {name: plain.positions[:, plain.names.index(name)] for name in plain.names}
    assert np.array_equal(named.positions[:, 0], found["/base"])
    assert np.allclose(named.positions[:, 1], np.stack([*lab.positions[:, 1, [0, 2]].T * [[1], [-1]], 0 * lab.time], axis=1))
    assert np.array_equal(named.positions[:, 2], found["/tip"], equal_nan=True)


def test_messages_of_one_kind_are_chosen_from_a_topic(tmp_path):
    """As a laboratory streams the markers of an arm: all on one topic, told from each other by a number."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    types, kind = store.types, "visualization_msgs/msg/Marker"
    with Writer(tmp_path / "run.bag") as writer:
        topic = writer.add_connection("/one", kind, typestore=store)
        for n in range(20):
            at, header = headers(types, n / 50)
            place = types["geometry_msgs/msg/Point"](float(n), 2.0, 3.0)
            marker = blank_marker(types, types[kind], header, types["geometry_msgs/msg/Pose"](place, quaternion(types)))
            marker.id = n % 2
            writer.write(topic, at, store.serialize_ros1(marker, kind))
    text = '[points]\ntip = ["/one:[id=1].pose.position.x", "/one:[id=1].pose.position.y", "/one:[id=1].pose.position.z"]\n'
    (tmp_path / "map.toml").write_text(text, encoding="utf-8")
    capture = read_capture(tmp_path / "run.bag", None, read_mapping(tmp_path / "map.toml"))
    assert capture.positions[:, 0, 0].tolist() == list(range(1, 20, 2))
    assert np.allclose(capture.time, np.arange(10) / 25, atol=1e-8)
    for old, new, said in (("id=1", "ID=1", "did you mean 'id'?"), ("id=1", "id=7", "'tip' in /one: expected messages with")):
        (tmp_path / "map.toml").write_text(text.replace(old, new), encoding="utf-8")
        with pytest.raises(RecordingError) as caught:
            read_capture(tmp_path / "run.bag", None, read_mapping(tmp_path / "map.toml"))
        assert said in str(caught.value)


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("/base:pose.position.y", "/tip:point.y", "point 'base': expected fields of one topic, got /base and /tip"),
        ("/base:pose.position.y", "/bas:pose.position.y", "fields of one topic"),
        ("/base:pose.position.y", "/base:pose.position.w", "/base has no field 'pose.position.w'"),
        ("/base:pose.position.y", "/base:pose.position", "field 'pose.position' of /base: expected a number"),
        ("/base:pose.position.y", "/base:pose position", "expected topic:field"),
    ],
)
def test_a_wrong_field_of_a_point_is_named(bag, tmp_path, old, new, said):
    text = FIELDS
    assert old in text
    (tmp_path / "map.toml").write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(RecordingError) as caught:
        read_capture(bag[0], None, read_mapping(tmp_path / "map.toml"))
    assert said in str(caught.value)


def test_the_first_messages_of_transforms_are_read_too(tmp_path):
    """The type tf/tfMessage, which bags of the first years of ROS 1 have."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf/msg/tfMessage"))
    types = store.types
    with Writer(tmp_path / "run.bag") as writer:
        topic = writer.add_connection("/tf", "tf/msg/tfMessage", typestore=store)
        for n in range(5):
            at, header = headers(types, n / 50)
            place = types["geometry_msgs/msg/Transform"](types["geometry_msgs/msg/Vector3"](0.1 * n, 2.0, 3.0), quaternion(types))
            one = types["geometry_msgs/msg/TransformStamped"](header, "tip", place)
            writer.write(topic, at, store.serialize_ros1(types["tf/msg/tfMessage"]([one]), "tf/msg/tfMessage"))
    capture = read_capture(tmp_path / "run.bag")
    assert capture.names == ("/tf/tip",)
    assert np.allclose(capture.positions[:, 0, 0], 0.1 * np.arange(5))


def test_a_damaged_bag_is_refused_in_one_line(bag):
    path, _ = bag
    file = path if path.is_file() else next(path.glob("*.db3"))
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 3])
    with pytest.raises(RecordingError, match="the bag cannot be read"):
        read_capture(path)


def test_without_the_library_its_group_is_named(bag, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rosbags.highlevel", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'hsr_pin\[ros\]'"):
        read_capture(bag[0])
