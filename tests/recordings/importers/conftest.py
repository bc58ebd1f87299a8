"""A known motion in a laboratory, and the files that tracking systems would have made of it."""

import csv
import io

import numpy as np
import pytest

RATE = 120.0
MM = 1000.0


def fields(values):
    return ["" if not np.isfinite(value) else f"{value:.6f}" for value in np.ravel(values)]


def text_of(rows):
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def nexus(path, names, positions, unit="mm", title="Trajectories", rate=RATE, first_frame=7, devices=True):
    """Vicon Nexus: a section of devices, an empty line, the trajectories."""
    rows = []
    if devices:
        rows += [
            ["Devices"],
            [1000],
            ["", "", "Force"],
            ["Frame", "Sub Frame", "Fx"],
            ["", "", "N"],
            [1, 0, 5.5],
            [1, 1, 5.6],
            [],
        ]
    rows += [[title], [f"{rate:g}"], ["", ""] + [cell for name in names for cell in (name, "", "")]]
    rows += [["Frame", "Sub Frame", *["X", "Y", "Z"] * len(names)], ["", "", *[unit] * 3 * len(names)]]
    factor = {"mm": MM, "m": 1.0, "cm": 100.0}[unit]
    rows += [[first_frame + i, 0, *fields(factor * frame)] for i, frame in enumerate(positions)]
    path.write_text(text_of(rows), encoding="utf-8-sig")


def tracker(path, names, positions, rate=RATE):
    """Vicon Tracker: objects with rotation and translation."""
    rows = [["Objects"], [f"{rate:g}"], ["", ""] + [cell for name in names for cell in (name, *[""] * 5)]]
    rows += [["Frame", "Sub Frame", *["RX", "RY", "RZ", "TX", "TY", "TZ"] * len(names)]]
    rows += [["", "", *["rad", "rad", "rad", "mm", "mm", "mm"] * len(names)]]
    for i, frame in enumerate(positions):
        rows.append([i + 1, 0, *[cell for place in frame for cell in ("0.1", "0.2", "0.3", *fields(MM * place))]])
    path.write_text(text_of(rows), encoding="utf-8")


def motive(path, names, positions, unit="Meters", version="1.23", labelled=True, rate=RATE):
    """OptiTrack Motive: a rigid body with a quaternion first, then the markers."""
    factor = {"Meters": 1.0, "Millimeters": MM, "Centimeters": 100.0}[unit]
    body, solved = ["Rigid Body"] * 8, [f"{names[0]}"] * 8
    types = [*body, *[kind for _ in names for kind in ["Marker"] * 3]]
    labels = [*solved, *[name for name in names for _ in range(3)]]
    kinds = [*["Rotation"] * 4, *["Position"] * 3, "Mean Marker Error", *["Position"] * 3 * len(names)]
    axes = ["X", "Y", "Z", "W", "X", "Y", "Z", "", *["X", "Y", "Z"] * len(names)]
    rows = [["Format Version", version, "Take Name", "a, take", "Export Frame Rate", f"{rate:.6f}", "Length Units", unit]]
    rows[0] += ["Total Exported Frames", len(positions)]
    rows += [[], ["", "Type" if labelled else "", *types], ["", "Name" if labelled else "", *labels]]
    if labelled:
        rows.append(["", "ID", *["4CF0B31A"] * len(labels)])
    rows += [["", "", *kinds], ["Frame", "Time (Seconds)", *axes]]
    for i, frame in enumerate(positions):
        rows.append([i, f"{3 + i / rate:.6f}", *["0.1"] * 4, "9", "9", "9", "0.001", *fields(factor * frame)])
    path.write_text(text_of(rows), encoding="utf-8")


def c3d(path, names, positions, unit="mm", rate=RATE, up="+Z"):
    import ezc3d

    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["UNITS"]["value"], point["RATE"]["value"], point["LABELS"]["value"] = [unit], [rate], list(names)
    file.add_parameter("POINT", "Y_SCREEN", up)
    factor = {"mm": MM, "m": 1.0}[unit]
    points = np.ones((4, len(names), len(positions)))
    points[:3] = factor * positions.transpose(2, 1, 0)
    file["data"]["points"] = points
    file.write(str(path.with_suffix(".c3d")))  # it would add the suffix of itself
    path.with_suffix(".c3d").rename(path)


def old_nexus(path, names, positions, rate=RATE):
    """Vicon Workstation and Nexus 1: titles in capitals, a unit of the rate, no units of length."""
    rows = [["EVENTS"], [f"{rate:g}", "Hz"], ["Subject", "Context", "Name", "Time (s)", "Description"], []]
    rows += [["TRAJECTORIES"], [f"{rate:.6f}", "Hz"], [""] + [cell for name in names for cell in (name, "", "")]]
    rows += [["Field #", *["X", "Y", "Z"] * len(names)]]
    rows += [[i + 1, *fields(MM * frame)] for i, frame in enumerate(positions)]
    rows += [[], ["ANALOG"], ["1000.000000", "Hz"], ["Sample #", "Fx"], [1, "0.5"], [2, "0.6"]]
    path.write_text(text_of(rows), encoding="utf-8")


def legacy_motive(path, names, positions, rate=RATE):
    """Motive before 1.5: each row says what it is; every marker that was seen follows its frame."""
    lines = ['comment,"OptiTrack Export Data"', "righthanded", "info,version,1.1", f"info,framecount,{len(positions)}"]
    lines += ["info,rigidbodycount,1", 'rigidbody,"Base",7,3,0,0,0,0,0,0,0,0,0']
    for i, frame in enumerate(positions):
        body = [7, 9, 9, 9, 0, 0, 0, 1, 0, 0, 0]
        seen = [(place, name) for place, name in zip(frame, names, strict=True) if np.isfinite(place).all()]
        markers = [cell for n, (place, name) in enumerate(seen) for cell in (*fields(place), n + 1, name)]
        lines.append(",".join(map(str, ["frame", i, f"{i / rate:.8f}", 1, *body, len(seen), *markers])))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def qualisys(path, names, positions, rate=RATE, columns=True, version=""):
    """Qualisys Track Manager: keys and values, then (where asked for) a line of columns with frame and time."""
    lines = [f"FILE_VERSION\t{version}"] if version else []
    lines += [f"NO_OF_FRAMES\t{len(positions)}", "NO_OF_CAMERAS\t8", f"NO_OF_MARKERS\t{len(names)}", f"FREQUENCY\t{rate:g}"]
    lines += ["TIME_STAMP\t2026-01-19, 10:19:43.755\t2063631.96", "DATA_INCLUDED\t3D", "MARKER_NAMES\t" + "\t".join(names)]
    if columns:
        lines.append("\t".join(["Frame", "Time", *(f"{name} {axis}" for name in names for axis in "XYZ")]))
    for i, frame in enumerate(positions):
        lead = [str(i + 1), f"{i / rate:.5f}"] if columns else []
        lines.append("\t".join([*lead, *fields(MM * frame)]) + "\t")
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode())


def trc(path, names, positions, unit="mm", rate=RATE):
    """Motion Analysis and OpenSim."""
    factor = {"mm": MM, "m": 1.0}[unit]
    keys = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units", "OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"]
    values = [f"{rate:.2f}", f"{rate:.2f}", len(positions), len(names), unit, f"{rate:.2f}", 1, len(positions)]
    lines = ["PathFileType\t4\t(X/Y/Z)\ttake.trc", "\t".join(keys), "\t".join(map(str, values))]
    lines += ["Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t"]
    lines += ["\t\t" + "\t".join(f"{axis}{n + 1}" for n in range(len(names)) for axis in "XYZ"), ""]
    lines += ["\t".join([str(i + 1), f"{i / rate:.3f}", *fields(factor * frame)]) for i, frame in enumerate(positions)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


WRITERS = {
    "nexus": nexus,
    "tracker": tracker,
    "old nexus": old_nexus,
    "motive": motive,
    "legacy motive": legacy_motive,
    "qualisys": qualisys,
    "trc": trc,
    "c3d": c3d,
}


class Laboratory:
    """A hanging, upright or horizontal arm that swings, somewhere in a laboratory with axes of its own."""

    arcs = (0.0, 0.12, 0.24)
    names = ("Arm:base", "Arm:mid", "Arm:tip")
    writers = WRITERS
    rate = RATE

    def __init__(self, bend, mount="hanging", up="+z", yaw=0.7, noise=0.0, seed=0, seconds=3.0):
        time = np.arange(int(seconds * RATE)) / RATE
        since = np.maximum(time - 0.5, 0)
        self.time, self.torque = time, np.where(time < 0.5, 0.0, 0.8)
        self.angle = 1.2 * (1 - np.exp(-3 * since) * np.cos(9 * since))
        x, y, z = np.moveaxis(np.stack([bend(self.angle, arc) for arc in self.arcs], axis=1), -1, 0)
        world = {"hanging": (x, y, z), "upright": (x, y, -z), "horizontal": (-z, y, -x)}[mount]
        self.world = np.stack(world, axis=-1)
        cos, sin = np.cos(yaw), np.sin(yaw)
        turned = self.world @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
        turn = {"+z": "xyz", "+y": "zxy", "-x": "yZX"}[up]  # where the arm's x, y, z point; a capital: the other way
        self.turn = np.array([(-1 if axis.isupper() else 1) * np.eye(3)["xyz".index(axis.lower())] for axis in turn])
        self.place = np.array([0.4, -1.3, 2.1])
        rng = np.random.default_rng(seed)
        self.positions = turned @ self.turn + self.place + noise * rng.standard_normal(turned.shape)


@pytest.fixture(scope="session")
def laboratory(bending):
    def make(*args, **kwargs):
        return Laboratory(bending, *args, **kwargs)

    return make


@pytest.fixture(scope="session")
def writers():
    return WRITERS
