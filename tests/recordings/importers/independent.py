"""What files of tracking systems hold, by ezc3d, rosbags and a few lines each: nothing here is shared with the importers.

Each parse gives the names of points (None: not told), (T, K, 3) positions in the file's own unit, and times [s] (None: not told).
"""

import csv
import re
import resource
import struct

import numpy as np

#: So much memory a library may take for one file [bytes]: damaged C3D files made ezc3d take 12 GB.
ROOM = 1 << 30


def numbers(fields):
    out = []
    for field in fields:
        try:
            out.append(float(field))
        except ValueError:
            out.append(np.nan)
    return out


def padded(rows):
    width = max(map(len, rows))
    return np.array([row + [np.nan] * (width - len(row)) for row in rows])


def text(path):
    return path.read_bytes().decode("utf-8-sig", "replace").replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")


def c3d(path):
    """By ezc3d; by the header alone where ezc3d fails, or reads garbage (steps three times as long)."""
    data = path.read_bytes()
    processor = data[(data[0] - 1) * 512 + 3]
    order = ">" if processor == 86 else "<"
    points, analog, first, last = struct.unpack_from(f"{order}4H", data, 2)
    (scale,), (block,) = struct.unpack_from(f"{order}f", data, 12), struct.unpack_from(f"{order}H", data, 16)
    if processor == 85:  # DEC: halves exchanged, and four times the value
        scale = struct.unpack("<f", data[14:16] + data[12:14])[0] / 4
    kind, count = f"{order}f4" if scale < 0 else f"{order}i2", last - first + 1
    plain, theirs, names, time = None, None, None, None
    if processor != 85 or scale > 0:
        flat = np.frombuffer(data, kind, offset=(block - 1) * 512)[: count * (4 * points + analog)]
        quads = flat.reshape(-1, 4 * points + analog)[:, : 4 * points].reshape(-1, points, 4).astype(float)
        seen = quads[:, :, 3:] >= 0
        plain = np.where(seen | ~seen.any(), quads[:, :, :3] * (1 if scale < 0 else scale), np.nan)
    content = by_ezc3d(path)
    if content is not None:
        theirs = content["data"]["points"][:3].transpose(2, 1, 0)
        seen = content["data"]["meta_points"]["residuals"][0].T[:, :, None] >= 0
        theirs = np.where(seen | ~seen.any(), theirs, np.nan)
    nothing = theirs is None or not np.isfinite(theirs).any()
    if plain is not None and (nothing or typical(theirs) > 3 * typical(plain) > 0):
        return None, plain, None
    rate = content["parameters"]["POINT"].get("RATE", {"value": [0]})["value"]
    names = [name.strip() for name in content["parameters"]["POINT"]["LABELS"]["value"]]
    if len(names) != theirs.shape[1] or not all(name.isascii() and name for name in names):
        names = None
    if len(rate) and rate[0] > 0:
        time = np.arange(len(theirs)) / rate[0]
    return names, theirs, time


def by_ezc3d(path):
    import ezc3d

    usual = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm", encoding="ascii") as file:
        taken = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + ROOM, usual[1]))
    try:
        return ezc3d.c3d(str(path))
    except (OSError, ValueError, RuntimeError, IndexError, MemoryError):
        return None
    finally:
        resource.setrlimit(resource.RLIMIT_AS, usual)


def typical(positions):
    """The mean step: still channels that are read as points have a small median, but leaps between them."""
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=2)
    return np.mean(steps[np.isfinite(steps)]) if np.isfinite(steps).any() else 0.0


def trc(path):
    lines = text(path)
    top = next(n for n, line in enumerate(lines) if line.lower().startswith("frame"))
    names = [name.strip() for name in lines[top].split("\t")[2:] if name.strip()]
    body = padded([numbers(line.split("\t")) for line in lines[top + 1 :] if line.split("\t")[0].strip().isdigit()])
    return names, body[:, 2 : 2 + 3 * len(names)].reshape(len(body), len(names), 3), body[:, 1]


def qualisys(path):
    lines = text(path)
    top = next(n for n, line in enumerate(lines) if line.startswith(("MARKER_NAMES", "BODY_NAMES")))
    names = [name for name in lines[top].split("\t")[1:] if name]
    rate = next(float(line.split("\t")[1]) for line in lines if line.startswith("FREQUENCY"))
    if lines[top].startswith("B"):
        return names, *bodies_of(lines[top + 1 :], len(names), rate)
    body = padded([numbers(line.split("\t")) for line in lines[top + 1 :] if numbers(line.split("\t")[:1])[0] > -1e9])
    lead = 2 if any(line.startswith("Frame\tTime") for line in lines[top : top + 3]) else 0
    places = np.stack([body[:, lead + 3 * n : lead + 3 * n + 3] for n in range(len(names))], axis=1)
    return names, places, np.arange(len(body)) / rate


def bodies_of(lines, count, rate):
    """Sixteen numbers each, which an empty column may part."""
    rows = [[field for field in numbers(line.split("\t")) if np.isfinite(field)] for line in lines]
    rows = np.array([row[-16 * count :] for row in rows if len(row) >= 16 * count])
    return rows.reshape(len(rows), count, 16)[:, :, :3], np.arange(len(rows)) / rate


def vicon(path):
    rows = list(csv.reader(text(path)))
    top = next(n for n, row in enumerate(rows) if row and row[0].strip().lower() in ("trajectories", "markers", "objects"))
    axes = next(n for n in range(top, len(rows)) if rows[n] and rows[n][0] in ("Frame", "Field #"))
    starts = [n for n, name in enumerate(rows[axes]) if name.upper() in ("X", "TX")]
    names = [next(name for name in reversed(rows[axes - 1][: n + 1]) if name) for n in starts]
    body = []
    for row in rows[axes + 1 :]:
        if row and row[0].isdigit():
            body.append(numbers(row))
        elif body:
            break
    body = padded(body)
    time = (body[:, 0] - body[0, 0]) / float(rows[top + 1][0])
    return names, np.stack([body[:, n : n + 3] for n in starts], axis=1), time


def motive(path):
    rows = list(csv.reader(text(path)))
    top = next(n for n, row in enumerate(rows) if row and row[0] == "Frame")
    starts = [n for n, kind in enumerate(rows[top - 1]) if kind == "Position" and rows[top][n] == "X"]
    names = next(row for row in rows[:top] if row[1:2] == ["Name"])
    body = padded([numbers(row) for row in rows[top + 1 :] if row])
    return [names[n] for n in starts], np.stack([body[:, n : n + 3] for n in starts], axis=1), body[:, 1]


def legacy(path):
    """Of the first body of the file: where its frames have it."""
    rows = [row for row in csv.reader(text(path)) if row[0] == "frame"]
    found = np.full((len(rows), 1, 3), np.nan)
    wanted = next(row[4] for row in rows if int(row[3]))
    for n, row in enumerate(rows):
        for start in range(4, 4 + 11 * int(row[3]), 11):
            if row[start] == wanted:
                found[n, 0] = numbers(row[start + 1 : start + 4])
    return None, found, np.array([float(row[2]) for row in rows])


def mapped(path, mapping):
    """A table separated by commas or spaces, its numbers taken where the mapping says."""
    lines = text(path)
    split = (lambda line: line.split()) if "," not in lines[-1] else (lambda line: next(csv.reader([line])))
    first = 1 if mapping.header is None else mapping.header
    names = [] if first == 0 else [name.strip() for name in split(lines[first - 1].lstrip("#% "))]
    body = padded([numbers(split(line)) for line in lines[first:] if np.isfinite(numbers(split(line))[-1:]).any()])

    def track(place):
        if place.column is None:
            return np.zeros(len(body))
        if isinstance(place.column, int):
            return np.sign(place.column) * body[:, abs(place.column) - 1]
        turned = place.column.startswith("-") and place.column not in names
        return (-1 if turned else 1) * body[:, names.index(place.column.removeprefix("-") if turned else place.column)]

    places = np.stack([np.stack([track(place) for place in triple], axis=1) for _, triple in mapping.points], axis=1)
    names_of_points = [name for name, _ in mapping.points]
    if mapping.time is None or mapping.time.form is not None:
        return names_of_points, places, None
    columns = [one - 1 if isinstance(one, int) else names.index(one) for one in mapping.time.columns]
    stamps = sum(factor * body[:, column] for factor, column in zip(mapping.time.factors, columns, strict=True))
    new = np.concatenate([[True], np.diff(stamps) > 0])
    return names_of_points, places[new], stamps[new]


def bag(path, mapping, clock):
    """Every topic of poses or transforms, or every point of a mapping, along straight lines at the times of a capture [s]."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    tracks = {}
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_FOXY)) as reader:
        for one, received, raw in reader.messages():
            if "static" in one.topic:
                continue
            try:
                message = reader.deserialize(raw, one.msgtype)
            except KeyError:
                continue
            for name, place, stamped in points_of(one, message) if mapping is None else chosen_of(one, message, mapping):
                stamp = stamped.header.stamp.sec * 10**9 + stamped.header.stamp.nanosec if hasattr(stamped, "header") else 0
                tracks.setdefault(name, {}).setdefault(stamp or received, place)
    places = []
    for track in tracks.values():
        stamps = sorted(track)
        since = np.array([(stamp - clock[0]) / 1e9 for stamp in stamps])
        values = np.array([track[stamp] for stamp in stamps], dtype=float)
        place = np.stack([np.interp(clock[1], since, values[:, axis]) for axis in range(3)], axis=1)
        after = np.clip(np.searchsorted(since, clock[1]), 1, len(since) - 1)
        far = since[after] - since[after - 1] > 1.7 * np.median(np.diff(since))  # a gap
        places.append(np.where(far[:, None], np.nan, place))
    return list(tracks), np.stack(places, axis=1), None


def points_of(one, message):
    def xyz(place):
        return place.x, place.y, place.z

    if "TFMessage" in one.msgtype or "tfMessage" in one.msgtype:
        return [(f"{one.topic}/{part.child_frame_id}", xyz(part.transform.translation), part) for part in message.transforms]
    if "TransformStamped" in one.msgtype:
        return [(one.topic, xyz(message.transform.translation), message)]
    if one.msgtype.endswith(("/PoseStamped", "/PoseWithCovarianceStamped", "/Odometry")):
        pose = message.pose.position if hasattr(message.pose, "position") else message.pose.pose.position
        return [(one.topic, xyz(pose), message)]
    return []


def chosen_of(one, message, mapping):
    found = []
    for name, triple in mapping.points:
        ways = [str(place.column or "").removeprefix("-") for place in triple]
        if all(way.split(":")[0] in ("", one.topic) for way in ways):
            place = [0.0 if not way else walked(message, way.split(":", 1)[1]) for way in ways]
            signs = [-1 if str(place.column).startswith("-") else 1 for place in triple]
            if None not in place:
                found.append((name, [sign * value for sign, value in zip(signs, place, strict=True)], message))
    return found


def walked(value, way):
    for part in re.findall(r"\w+=\w+|\w+", way):
        key, _, wanted = part.partition("=")
        if wanted and not isinstance(value, list):
            if str(getattr(value, key)) != wanted:
                return None
        elif wanted:
            value = next((one for one in value if str(getattr(one, key)) == wanted), None)
        else:
            value = value[int(part)] if part.isdigit() else getattr(value, part)
        if value is None:
            return None
    return value
