"""Reading and validation of the file ``dataset.toml`` that declares a dataset."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

from hsr_pin.obstacles import Obstacle
from hsr_pin.recordings.document import Section, read_document
from hsr_pin.recordings.obstacles import obstacles_of
from hsr_pin.recordings.plausible import implausible_payload, implausible_size
from hsr_pin.recordings.poses import PARTS
from hsr_pin.recordings.sections import channels_of, declared_whole, sections_of, torque_columns
from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import BENDS, MOUNTS, Channel, Marker
from hsr_pin.trajectory import Section as ArmSection

#: Versions of the format that are read and written; version 2 adds arms that bend in space.
VERSIONS = (1, 2)
#: Keys of [robot] in both versions.
_ROBOT = ("length", "mass", "diameter", "mount", "keq", "damping", "input", "smoothed", "weighed")
#: Additions of version 2: tables, and keys in [robot] and in [[marker]].
_TABLES_IN_SPACE = ("section", "input", "measured")
_ROBOT_IN_SPACE, _MARKER_IN_SPACE = ("bending", "torsion"), ("radius", "angle", "orientation")
#: Name of the file that declares a folder to be a dataset.
FILE_NAME = "dataset.toml"
#: Accepted lengths of an arm [m]; any other length is probably not in metres.
SHORTEST, LONGEST = 1e-3, 50.0
#: Largest number of markers; computations over all pairs of markers grow with its square.
MOST_MARKERS = 200
#: Of the chain that simulated a dataset: largest number of links, and accepted placements of the joints.
MOST_LINKS, PLACEMENTS = 1000, ("base", "mid", "shifted")
#: Largest width of the moving average that tracks may have passed through [samples].
WIDEST = 101
#: Accepted interpolations of the input between samples, the default first.
INPUTS = ("held", "interpolated")


@dataclass(frozen=True, eq=False)
class TrialDeclaration:
    """Contents of a table ``[[trial]]``: the file (relative to the dataset) and numbers of :class:`~hsr_pin.trajectory.Trial`."""

    file: str
    keq: float
    damping: float | None
    tip_mass: float
    t_start: float | None
    interpolated: bool | None
    section: Section

    @property
    def name(self) -> str:
        """Name of the trial: the stem of its file name."""
        return PurePosixPath(self.file).stem


@dataclass(frozen=True, eq=False)
class Declaration:
    """Contents of a ``dataset.toml``.

    The attributes are those of :class:`~hsr_pin.trajectory.Dataset`, and ``posed``: the markers whose orientation is recorded.
    """

    name: str
    description: str
    length: float
    mass: float
    diameter: float
    mount: str
    markers: tuple[Marker, ...]
    trials: tuple[TrialDeclaration, ...]
    bending: str
    torsion: float
    sections: tuple[ArmSection, ...]
    channels: tuple[Channel, ...]
    posed: tuple[Marker, ...]
    chain: tuple[int, str] | None
    smoothed: int | None
    weighed: bool
    obstacles: tuple[Obstacle, ...]

    @property
    def inputs(self) -> tuple[tuple[str, ...], ...]:
        """Accepted sets of columns for the input of a trial."""
        if self.bending == "plane":
            return ("P1", "P2"), ("tau",)
        channels = tuple(channel.name for channel in self.channels)
        return ((channels,) if channels else ()) + (torque_columns(len(self.sections)),)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns that are not input."""
        places = (f"{marker.name}_{axis}" for marker in self.markers for axis in "xyz")
        return "t", *places, *(f"{marker.name}_{part}" for marker in self.posed for part in PARTS)


def read_declaration(path: Path) -> Declaration:
    """Read and check a ``dataset.toml``.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    top = read_document(path)
    newer = _version(top) == VERSIONS[1]
    top.only(
        "format",
        "name",
        "description",
        "robot",
        "marker",
        "trial",
        "simulation",
        "obstacle",
        *(_TABLES_IN_SPACE if newer else ()),
    )
    robot = top.section("robot")
    robot.only(*_ROBOT, *(_ROBOT_IN_SPACE if newer else ()))
    length = robot.number("length", "m")
    if not SHORTEST <= length <= LONGEST:
        raise robot.fault(
            "length",
            "length",
            expected=f"{SHORTEST} to {LONGEST} m",
            received=length,
            hint="lengths and coordinates are in metres",
        )
    mount = robot.text("mount")
    if mount not in MOUNTS:
        raise robot.fault("mount", "mount", expected=" or ".join(MOUNTS), received=mount, hint=nearest(mount, MOUNTS, "mounts"))
    bending = robot.text("bending", BENDS[0])
    if bending not in BENDS:
        raise robot.fault(
            "bending", "bending", expected=" or ".join(BENDS), received=bending, hint=nearest(bending, BENDS, "words")
        )
    space = bending == "space"
    if space and mount == "flat":
        hint = 'an arm in space that lies has mount = "horizontal"'
        raise robot.fault("mount", "mount", expected="not flat for an arm in space", received=mount, hint=hint)
    for table, key in ((robot, "torsion"), *((top, name) for name in _TABLES_IN_SPACE)):
        if key in table.values and not space:
            raise table.fault(key, key, expected='bending = "space" together with this key', received=bending)
    mass, markers = robot.number("mass", "kg"), _markers(top, length, space)
    diameter = robot.number("diameter", "m")
    if reason := implausible_size(length, mass, diameter):
        raise robot.fault(reason.key, reason.key, **reason.facts)
    sections = sections_of(top, robot, length, mass)
    declaration = Declaration(
        name=top.text("name"),
        description=top.text("description", ""),
        length=length,
        mass=mass,
        diameter=diameter,
        mount=mount,
        markers=markers,
        trials=_trials(top, robot, declared_whole(top, sections), mass),
        bending=bending,
        torsion=robot.number("torsion", "Nm/rad", zero=True) if "torsion" in robot.values else math.inf,
        sections=sections,
        channels=(),
        chain=_chain(top),
        smoothed=_smoothed(robot),
        weighed=_weighed(robot),
        obstacles=obstacles_of(top),
        posed=tuple(m for m, values in zip(markers, top.values["marker"], strict=True) if values.get("orientation")),
    )
    taken = {*declaration.columns, *torque_columns(len(sections))}
    return replace(declaration, channels=channels_of(top, max(1, len(sections)), taken))


def _chain(top: Section) -> tuple[int, str] | None:
    """Return the number of links and the joint placement of a simulated dataset, from its table ``simulation``."""
    if "simulation" not in top.values:
        return None
    table = top.section("simulation")
    table.only("links", "placement")
    links, placement = table.number("links", "links"), table.text("placement")
    if links != int(links) or links > MOST_LINKS:
        raise table.fault("links", "links", expected=f"a whole number from 1 to {MOST_LINKS}", received=links)
    if placement not in PLACEMENTS:
        raise table.fault("placement", "placement", expected=" or ".join(PLACEMENTS), received=placement)
    return int(links), placement


def _weighed(robot: Section) -> bool:
    """Return whether the declared mass was weighed, in which case it is not questioned."""
    value = robot.values.get("weighed", False)
    if not isinstance(value, bool):
        raise robot.fault("weighed", "weighed", expected="true or false", received=repr(value)[:60])
    return value


def _smoothed(robot: Section) -> int | None:
    """Return the width of the moving average that the tracks passed through [samples]; 1: not smoothed; None: not declared."""
    if "smoothed" not in robot.values:
        return None
    width = robot.number("smoothed", "samples")
    if width % 2 != 1 or width > WIDEST:
        raise robot.fault("smoothed", "smoothed", expected=f"an odd number of samples, from 1 to {WIDEST}", received=width)
    return int(width)


def _version(top: Section) -> int:
    version = top.values.get("format")
    if version not in VERSIONS or isinstance(version, (bool, float)):
        raise top.fault(
            "format version",
            "format",
            expected=" or ".join(f"format = {version}" for version in VERSIONS),
            received="none" if version is None else repr(version)[:60],
            hint="this version of hsr_pin reads no other version",
        )
    return int(version)


def _markers(top: Section, length: float, space: bool) -> tuple[Marker, ...]:
    markers: list[Marker] = []
    taken: set[str] = set()
    if (count := len(top.sections("marker"))) > MOST_MARKERS:
        raise top.sections("marker")[MOST_MARKERS].fault("markers", expected=f"at most {MOST_MARKERS}", received=count)
    for section in top.sections("marker"):
        section.only("name", "arc_length", *(_MARKER_IN_SPACE if space else ()))
        name = section.text("name")
        if name != name.strip():
            raise section.fault("marker name", "name", expected="a name without leading or trailing spaces", received=repr(name))
        if name in taken:
            raise section.fault(f"two markers are named {name!r}", "name", hint="give each marker its own name")
        taken |= {name, *(f"{name}:{axis}" for axis in "xy" if section.values.get("orientation"))}
        arc_length = section.number("arc_length", "m", zero=True)
        if arc_length > length * (1 + 1e-9):
            raise section.fault(
                "arc_length", "arc_length", expected=f"from 0 to the arm's length, {length} m", received=arc_length
            )
        radius = section.number("radius", "m", zero=True) if "radius" in section.values else 0.0
        if radius > length:
            raise section.fault("radius", "radius", expected=f"from 0 to the arm's length, {length} m", received=radius)
        angle = section.angle("angle") if "angle" in section.values else 0.0
        if not isinstance(turned := section.values.get("orientation", False), bool):
            raise section.fault("orientation", "orientation", expected="true or false", received=repr(turned)[:60])
        markers.append(Marker(name, arc_length, radius, angle))
    if all(marker.arc_length == 0 for marker in markers):
        raise top.sections("marker")[0].fault("no moving marker", expected="at least one marker with arc_length above 0")
    return tuple(markers)


def _trials(top: Section, robot: Section, sections: dict[str, float], mass: float) -> tuple[TrialDeclaration, ...]:
    keq = robot.number("keq", "Nm/rad") if "keq" in robot.values else sections.get("keq")
    damping = robot.number("damping", "Nm s/rad", zero=True) if "damping" in robot.values else sections.get("damping")
    trials: list[TrialDeclaration] = []
    taken: set[str] = set()
    for section in top.sections("trial"):
        section.only("file", "keq", "damping", "tip_mass", "t_start", "input")
        values = section.values
        if keq is None and "keq" not in values:
            raise section.fault("keq is missing", expected="a number [Nm/rad] in [robot] or in this [[trial]]")
        trial = TrialDeclaration(
            file=section.text("file"),
            keq=section.number("keq", "Nm/rad") if keq is None or "keq" in values else keq,
            damping=section.number("damping", "Nm s/rad", zero=True) if "damping" in values else damping,
            tip_mass=section.number("tip_mass", "kg", zero=True) if "tip_mass" in values else 0.0,
            t_start=section.number("t_start", "s", sign=True) if "t_start" in values else None,
            interpolated=interpolated_in(section if "input" in values else robot),
            section=section,
        )
        if reason := implausible_payload(mass, trial.tip_mass):
            raise section.fault(reason.key, reason.key, **reason.facts)
        parts = PurePosixPath(trial.file).parts
        if not trial.name or ".." in parts or PurePosixPath(trial.file).is_absolute() or "\\" in trial.file:
            raise section.fault("file", "file", expected="a file inside the dataset's folder", received=repr(trial.file))
        if trial.name in taken:
            raise section.fault(f"two trials are named {trial.name!r}", "file", hint="give each trial its own file")
        taken.add(trial.name)
        trials.append(trial)
    return tuple(trials)


def interpolated_in(section: Section) -> bool | None:
    """Return whether the input is interpolated linearly between samples instead of held; None: not declared."""
    if "input" not in section.values:
        return None
    word = section.text("input")
    if word not in INPUTS:
        raise section.fault(
            "input", "input", expected=" or ".join(INPUTS), received=repr(word), hint=nearest(word, INPUTS, "words")
        )
    return word == INPUTS[1]
