"""C3D: whatever processor and maker wrote it, the size of the file decides where the points are."""

import resource
import struct
import time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hsr_pin.errors import HsrError, RecordingError
from hsr_pin.recordings.importers.detect import read_capture

FRAMES, POINTS, RATE = 40, 3, 100.0
QUICK = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def motion():
    """(T, K, 3) [mm], some of it not seen."""
    t = np.arange(FRAMES)[:, None, None] / RATE
    places = 100 * np.arange(1, POINTS + 1)[None, :, None] * np.stack([np.cos(t), np.sin(t), 1 + 0 * t], axis=-1)[:, :, 0]
    places[5:9, 1] = np.nan
    return places


def real32(values, processor):
    values = np.asarray(values, dtype="<f4")
    if processor == 85:  # DEC: four times the value of Intel's bits, halves exchanged
        return (values * 4).view("<u2").reshape(-1, 2)[:, ::-1].tobytes()
    return values.astype(">f4").tobytes() if processor == 86 else values.tobytes()


def file_of(
    places,
    processor=84,
    real=True,
    analog=0,
    said_analog=None,
    samples=1,
    parameters=(),
    without=(),
    frames=None,
    pad=True,
    scale=0.05,
):
    """The bytes of a C3D file, which may say of itself what is not so."""
    order = ">" if processor == 86 else "<"
    count, points = places.shape[:2]
    said = {
        ("POINT", "USED"): ("i2", [points]),
        ("POINT", "SCALE"): ("f4", [-1.0 if real else scale]),
        ("POINT", "RATE"): ("f4", [RATE]),
        ("POINT", "FRAMES"): ("i2", [frames or count]),
        ("POINT", "LABELS"): ("S", [f"p{n}" for n in range(points)]),
        ("POINT", "UNITS"): ("S", ["mm"]),
        ("ANALOG", "USED"): ("i2", [analog]),
        **dict(parameters),
    }
    groups = {name: n for n, name in enumerate(dict.fromkeys(group for group, _ in said), 1)}
    body = b""
    for name, number in groups.items():
        body += struct.pack("bb", len(name), -number) + name.encode() + struct.pack(f"{order}H", 3) + b"\0"
    for (group, name), (kind, values) in said.items():
        if (group, name) in without:
            continue
        if kind == "S":
            width = max((len(value) for value in values), default=0)
            content = struct.pack("bBBB", -1, 2, width, len(values)) + b"".join(value.encode().ljust(width) for value in values)
        else:
            raw = real32(values, processor) if kind == "f4" else struct.pack(f"{order}{len(values)}h", *values)
            content = struct.pack("bBB", 4 if kind == "f4" else 2, 1, len(values)) + raw
        content += b"\0"
        body += struct.pack("bb", len(name), groups[group]) + name.encode() + struct.pack(f"{order}H", len(content) + 2) + content
    blocks = -(-(len(body) + 6) // 512)
    section = (bytes([1, 0x50, blocks, processor]) + body).ljust(512 * blocks, b"\0")
    words = [points, analog * samples if said_analog is None else said_analog, 1, frames or count, 10]
    header = bytes([2, 0x50]) + struct.pack(f"{order}5H", *words) + real32([-1.0 if real else scale], processor)
    header += struct.pack(f"{order}2H", 2 + blocks, samples) + real32([RATE], processor)
    flat = np.full((count, 4 * points + analog * samples), 7.25)
    lost = ~np.isfinite(places).all(axis=2)
    quads = np.concatenate([np.nan_to_num(places) / (1 if real else scale), np.where(lost, -1, 0)[:, :, None]], axis=2)
    flat[:, : 4 * points] = quads.reshape(count, -1)
    data = real32(flat, processor) if real else np.round(flat).astype(f"{order}i2").tobytes()
    whole = header.ljust(512, b"\0") + section + data
    return whole + b"\0" * (-len(whole) % 512) if pad else whole


def read(tmp_path, content, unit=None):
    (tmp_path / "take").write_bytes(content)
    return read_capture(tmp_path / "take", unit)


def same(capture, places):
    assert capture.positions.shape == places.shape
    assert np.array_equal(np.isnan(capture.positions), np.isnan(places))
    return np.nanmax(np.abs(capture.positions - places / 1000))


@pytest.mark.parametrize("processor", [84, 85, 86], ids=["Intel", "DEC", "SGI"])
@pytest.mark.parametrize("real, error", [(True, 1e-7), (False, 3e-5)], ids=["real", "integer"])
@pytest.mark.parametrize("analog, samples", [(0, 1), (6, 10)])
def test_every_processor_and_number_is_read(tmp_path, processor, real, error, analog, samples):
    capture = read(tmp_path, file_of(motion(), processor, real, analog, samples=samples))
    assert same(capture, motion()) < error
    assert capture.names == ("p0", "p1", "p2")
    assert capture.rate == pytest.approx(RATE)


def test_a_library_reads_the_same(tmp_path):
    import ezc3d

    (tmp_path / "take.c3d").write_bytes(file_of(motion(), analog=0, parameters={("ANALOG", "RATE"): ("f4", [0.0])}))
    theirs = ezc3d.c3d(str(tmp_path / "take.c3d"))["data"]["points"][:3].transpose(2, 1, 0) / 1000
    ours = read_capture(tmp_path / "take.c3d").positions
    assert np.nanmax(np.abs(theirs - ours)) < 1e-9


LAYOUTS = {
    "no rate of the analog channels": {"analog": 6, "samples": 1},
    "a rate of them that is rounded": {"analog": 6, "samples": 10, "parameters": {("ANALOG", "RATE"): ("f4", [999.4])}},
    "a header that knows of none": {
        "analog": 6,
        "samples": 10,
        "said_analog": 0,
        "parameters": {("ANALOG", "RATE"): ("f4", [1000.0])},
    },
    "parameters that know of none": {"analog": 6, "samples": 10, "parameters": {("ANALOG", "USED"): ("i2", [0])}},
    "nothing but the header": {"without": {("POINT", name) for name in ("USED", "FRAMES", "SCALE", "RATE")}},
    "not filled up to a block": {"pad": False},
    "a frame too many in the parameters": {"parameters": {("POINT", "FRAMES"): ("i2", [FRAMES + 1])}, "pad": False},
}


@pytest.mark.parametrize("options", LAYOUTS.values(), ids=list(LAYOUTS))
def test_the_size_decides_where_the_file_contradicts_itself(tmp_path, options):
    assert same(read(tmp_path, file_of(motion(), **options)), motion()) < 1e-7


def test_points_that_are_all_marked_as_not_seen_are_taken_with_a_word(tmp_path):
    """Simi marks every point so."""
    places = np.nan_to_num(motion(), nan=50.0)
    content = bytearray(file_of(places))
    start = (struct.unpack_from("<H", content, 16)[0] - 1) * 512
    for quad in range(places.shape[0] * places.shape[1]):
        content[start + 16 * quad + 12 : start + 16 * quad + 16] = struct.pack("<f", -1)
    capture = read(tmp_path, bytes(content))
    assert same(capture, places) < 1e-7
    assert any("marked as not seen" in note for note in capture.notes)


def test_a_file_that_no_layout_fits_is_refused(tmp_path):
    content = file_of(motion(), analog=5, samples=7, said_analog=3, parameters={("ANALOG", "RATE"): ("f4", [500.0])})
    with pytest.raises(RecordingError, match=r"layout of the file is inconsistent.*export it again"):
        read(tmp_path, content + b"\0" * 5000)


@pytest.mark.parametrize("real, said", [(False, 0.02), (False, -0.05), (True, 0.05)])
def test_a_scale_that_the_header_contradicts_is_refused(tmp_path, real, said):
    """In a gait sample of c3d.org the parameter makes a child of the adult that the header has."""
    with pytest.raises(RecordingError, match=r"POINT:SCALE: expected -?[\d.]+, as in the header, got"):
        read(tmp_path, file_of(motion(), real=real, parameters={("POINT", "SCALE"): ("f4", [said])}))


def test_more_frames_than_16_bits_count(tmp_path):
    places = np.tile(motion()[:, :1], (1750, 1, 1))
    said = {("POINT", "FRAMES"): ("i2", [-1]), ("POINT", "LONG_FRAMES"): ("f4", [70000.0])}
    assert len(read(tmp_path, file_of(places, frames=65535, parameters=said)).time) == 70000
    fields = {("TRIAL", "ACTUAL_START_FIELD"): ("i2", [1, 0]), ("TRIAL", "ACTUAL_END_FIELD"): ("i2", [4464, 1])}
    assert (
        len(read(tmp_path, file_of(places, frames=65535, parameters={("POINT", "FRAMES"): ("i2", [-1])} | fields)).time) == 70000
    )
    assert len(read(tmp_path, file_of(places, frames=65535, without={("POINT", "FRAMES")}, pad=False)).time) == 70000


@pytest.mark.parametrize("share", [0.02, 0.2, 0.5, 0.75, 0.95])
def test_a_file_that_is_cut_is_refused_in_plain_words(tmp_path, share):
    content = file_of(motion(), analog=6, samples=10)
    with pytest.raises(RecordingError, match=r"truncated|ends (before|within) its parameters"):
        read(tmp_path, content[: int(share * len(content))])


def test_a_file_without_room_for_one_frame_is_cut(tmp_path):
    content = bytearray(8192)
    struct.pack_into("<BBHHHHHfHHf", content, 0, 2, 80, 65535, 0, 1, 65535, 10, -1.0, 3, 1, 100.0)
    content[512:516] = bytes([1, 80, 1, 84])
    with pytest.raises(RecordingError, match="truncated: expected all frames, got 0 of 1 frames"):
        read(tmp_path, bytes(content))


def test_a_small_file_that_wants_gigabytes_is_refused_at_once(tmp_path):
    content = bytearray(file_of(motion(), frames=FRAMES))
    content[2:6] = struct.pack("<2H", 65535, 65535)  # points and analog samples
    content[8:10] = struct.pack("<H", 65534)
    before, begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.perf_counter()
    with pytest.raises(RecordingError):
        read(tmp_path, bytes(content).replace(b"USED", b"USEX"))
    assert time.perf_counter() - begin < 2
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # kB


@QUICK
@given(cuts=st.lists(st.tuples(st.integers(0, 5000), st.integers(0, 6), st.binary(max_size=6)), min_size=1, max_size=4))
def test_random_bytes_changed_are_read_or_refused(tmp_path, cuts):
    content = file_of(motion(), analog=6, samples=10)
    for start, length, insert in cuts:
        at = start % len(content)
        content = content[:at] + insert + content[at + length :]
    try:
        capture = read(tmp_path, content)
    except HsrError as error:
        assert str(error).isprintable()
        return
    assert not np.isinf(capture.positions).any()


@pytest.mark.parametrize(
    "maker, screen, axis",
    [
        ("Qualisys", "-Z", "+z"),
        ("A.R.T. GmbH", "+Y", "+z"),
        ("Vicon", "+Z", "+z"),
        ("Motion Analysis Corp.", "+Z", "+z"),
        ("OptiTrack", "+Z", "+y"),
        ("", "+Z", "+z"),
        ("", "+Y", None),
        ("", "-Z", None),
        ("Nobody we know", "+X", None),
    ],
)
def test_up_is_what_the_maker_has_upwards_and_not_what_stands_upwards_on_a_screen(tmp_path, maker, screen, axis):
    said = {("POINT", "Y_SCREEN"): ("S", [screen]), ("MANUFACTURER", "COMPANY"): ("S", [maker or " "])}
    up = read(tmp_path, file_of(motion(), parameters=said)).up
    assert up.axis == axis
    assert screen in up.reason or axis is not None


def test_outputs_of_a_model_are_no_points(tmp_path):
    capture = read(tmp_path, file_of(motion(), parameters={("POINT", "ANGLES"): ("S", ["p1"])}))
    assert capture.names == ("p0", "p2")
    assert any("1 angles, forces and other model outputs" in note for note in capture.notes)


def test_a_unit_that_is_not_said_is_asked_for(tmp_path):
    content = file_of(motion(), without={("POINT", "UNITS")})
    with pytest.raises(RecordingError, match="--unit"):
        read(tmp_path, content)
    assert same(read(tmp_path, content, "mm"), motion()) < 1e-7
