"""Conversion between an arm and URDF text.

The straight arm lies along +z of the frame ``base``; every joint rotates about +y, so a positive angle bends the arm towards +x
of ``base``. Mounts: upright, ``base`` is the world frame; hanging, it is rotated by pi about x (positive bending is still towards
world +x); horizontal, by pi/2 about y (positive bending is towards world -z). ``tilt`` is a further rotation about y.

An arm that bends in space has two hinges at each joint, towards +x and then towards +y, and if it twists a third hinge about z.
Links of zero length between them carry a millionth of the link's mass, because some readers do not accept massless links. Other
readers can only use this form: successive hinges differ from the rotation vector of the arm in ``<hsr>``, and converge to it as
1/N only.

Springs, dampers and the arm's own numbers are stored in ``<hsr>`` under ``<robot>``, which other readers ignore.
There is no collision geometry: thick short links of a bent arm would collide with each other, which the real arm does not.
"""

from __future__ import annotations

import dataclasses
import math
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element

from hsr_pin.errors import SpecificationError, UrdfError
from hsr_pin.output import write_text
from hsr_pin.resources import resource
from hsr_pin.robot.appearance import shape
from hsr_pin.robot.links import base_rpy, links_of
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.xml_tree import XmlTree, parse_xml

if TYPE_CHECKING:
    from jinja2 import Template

#: Version of the extension element for planar arms and for arms in space; it increases if the meaning of an attribute changes.
VERSIONS = {"plane": 1, "space": 2}
#: Mass of a link of zero length, relative to that of the link after it.
SLIGHT = 1e-6

_FIELDS = tuple(field.name for field in dataclasses.fields(ArmSpecification) if field.name not in ("sections", "obstacles"))
#: Attributes of arms in space only, and attributes that are text.
_OF_SPACE, _WORDS = ("bending", "torsion", "cross_tilt"), ("placement", "mount", "bending")


def arm_to_urdf(spec: ArmSpecification) -> str:
    """Return the arm as URDF text, with numbers that are read back exactly.

    Raises:
        SpecificationError: the arm has sections, which the URDF format does not support.
    """
    if spec.sections:
        raise SpecificationError("sections", expected="none for a URDF", received=len(spec.sections))
    plain: dict[str, Any] = {name: _plain(getattr(spec, name)) for name in _FIELDS}
    spec = ArmSpecification(**plain)
    links = links_of(spec)
    middle = (spec.links + 1) // 2 - 1 if spec.placement == "base" else spec.links // 2
    return _template().render(
        version=VERSIONS[spec.bending],
        arm={name: value for name, value in plain.items() if spec.bending == "space" or name not in _OF_SPACE},
        slight=SLIGHT,
        joint_stiffness=spec.joint_stiffness,
        joint_damping=spec.joint_damping,
        base_rpy=base_rpy(spec),
        links=links,
        spec=spec,
        middle={"parent": links[middle].name, "z": spec.length / 2 - sum(link.length for link in links[:middle])},
        shape=shape(spec),
    )


def urdf_to_arm(text: str, source: str | Path | None = None) -> ArmSpecification:
    """Return the arm of a URDF, equal to the one that :func:`arm_to_urdf` was given.

    Args:
        text: content of the file.
        source: name of the file, for messages.

    Raises:
        UrdfError: the text is not XML, not a URDF, not written by hsr_pin, or was changed (its bodies and joints are not those of
            the arm that its extension element declares).
    """
    tree = parse_xml(text, source)
    spec = _read_extension(tree)
    _check_unchanged(tree, parse_xml(arm_to_urdf(spec)))
    return spec


def load_urdf(path: str | Path) -> ArmSpecification:
    """Read an arm from a URDF file; see :func:`urdf_to_arm`.

    Raises:
        UrdfError: the file cannot be read, or is invalid as for :func:`urdf_to_arm`.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "data that are not UTF-8 text"
        raise UrdfError("cannot read the file", expected="a URDF written by hsr-urdf", received=reason, file=path) from error
    return urdf_to_arm(text, path)


def save_urdf(spec: ArmSpecification, path: str | Path) -> None:
    """Write an arm to a URDF file, completely or not at all.

    Raises:
        OutputError: the file cannot be written.
    """
    write_text(path, arm_to_urdf(spec))


def _plain(value: Any) -> int | float | str:
    """Convert a NumPy number to a Python number."""
    return value if isinstance(value, str) else int(value) if hasattr(value, "__index__") else float(value)


@lru_cache(maxsize=1)
def _template() -> Template:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # late import: `--help` does not need it

    folder = resource("urdf_templates", "arm.urdf.jinja").parent
    environment = Environment(
        loader=FileSystemLoader(folder), undefined=StrictUndefined, autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template("arm.urdf.jinja")


def _read_extension(tree: XmlTree) -> ArmSpecification:
    make = "make one with hsr-urdf"
    if tree.root.tag != "robot":
        tree.fail("not a URDF", expected="<robot> around everything", received=f"<{tree.root.tag}>", hint=make)
    found = tree.root.findall("hsr")
    if len(found) != 1:
        received = "none" if not found else len(found)
        tree.fail("not a URDF of hsr_pin", expected="one <hsr> element under <robot>", received=received, hint=make)
    element = found[0]
    kind = next((bends for bends, version in VERSIONS.items() if element.get("version") == str(version)), None)
    if kind is None:
        hint, known = "read it with the hsr_pin that wrote it", " or ".join(f'version="{v}"' for v in VERSIONS.values())
        tree.fail("<hsr>", element, expected=known, received=repr(element.get("version")), hint=hint)
    values: dict[str, Any] = {}
    for name in (name for name in _FIELDS if kind == "space" or name not in _OF_SPACE):
        text = element.get(name)
        if text is None:
            tree.fail("<hsr>", element, expected=f"an attribute {name}", received="none", hint=make)
        values[name] = text if name in _WORDS else _number(text, int if name == "links" else float)
    try:
        return ArmSpecification(**values)
    except SpecificationError as error:
        tree.fail(f"<hsr> {error.subject}", element, expected=error.expected, received=error.received, hint=make)


def _number(text: str, kind: type[int] | type[float]) -> int | float | str:
    """Convert text to a number, or return the text, which the specification then rejects by name."""
    try:
        return kind(text)
    except ValueError:
        return text


def _check_unchanged(tree: XmlTree, declared: XmlTree) -> None:
    """Compare all kinematic and dynamic properties, to 1e-9, with those of the declared arm; visual properties may differ."""
    got, wanted = _physics(tree.root), _physics(declared.root)
    for name in (*got, *wanted):
        element, value = got.get(name, (tree.root, "nothing"))
        expected = wanted[name][1] if name in wanted else "nothing"
        if not _same(value, expected):
            hint = "change the arm with hsr-urdf, not the file by hand"
            tree.fail(f"{name.strip()} does not fit the arm in <hsr>", element, expected=expected, received=value, hint=hint)


def _physics(root: Element) -> dict[str, tuple[Element, str]]:
    """Return all attributes of links, joints and <hsr> but visual ones: "link link_1 inertial mass value" -> (element, text)."""
    facts: dict[str, tuple[Element, str]] = {}

    def walk(element: Element, path: str) -> None:
        while f"{path} " in facts:
            path += " (again)"
        facts[f"{path} "] = element, f"<{element.tag}>"
        facts.update({f"{path} {name}": (element, value) for name, value in element.items()})
        for part in element:
            if part.tag not in ("visual", "collision"):
                walk(part, f"{path} {part.tag}")

    for body in root:
        if body.tag in ("link", "joint", "hsr"):
            walk(body, f"{body.tag} {body.get('name', '')}".strip())
    return facts


def _same(a: str, b: str) -> bool:
    """Return whether two texts are equal, also as rows of numbers."""
    try:
        return a == b or all(math.isclose(float(x), float(y), rel_tol=1e-9) for x, y in zip(a.split(), b.split(), strict=True))
    except ValueError:
        return False
