"""Arm <-> URDF text.

The straight arm lies along +z of the frame ``base``; every joint turns about +y, so a positive angle bends the arm towards +x
of ``base``. Mounts: upright, ``base`` is the world frame; hanging, it is turned by pi about x (still bends towards world +x);
horizontal, by pi/2 about y (bends towards world -z). ``tilt`` is one more turn about y.

An arm that bends in space has two hinges in each place, towards +x and then towards +y, and where it twists a third about z, with
links of no length between them, which carry a millionth of the link's mass (some readers accept none without). That is what other
readers can have: hinges one after the other are not the rotation vector of the arm in ``<hsr>``, and come near it as 1/N only.

Springs and dampers, and the arm's own numbers, travel in ``<hsr>`` under ``<robot>``: other readers ignore it.
There is no collision geometry: thick short links of a bent arm would touch each other, which the real arm does not.
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

#: Version of the extension element for arms in the plane, and in space; a change of what its attributes mean raises it.
VERSIONS = {"plane": 1, "space": 2}
#: Mass of a link of no length, over that of the link beyond it.
SLIGHT = 1e-6

_FIELDS = tuple(field.name for field in dataclasses.fields(ArmSpecification) if field.name != "sections")
#: What only arms in space tell, and what is text.
_OF_SPACE, _WORDS = ("bending", "torsion", "cross_tilt"), ("placement", "mount", "bending")


def arm_to_urdf(spec: ArmSpecification) -> str:
    """Write the arm as URDF text, every number so that reading it gives back the same float.

    Raises:
        SpecificationError: it has sections, of which a URDF of ours knows nothing.
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
    """Rebuild the arm from its URDF, equal to the one that :func:`arm_to_urdf` was given.

    Args:
        text: the file's content.
        source: its name, for messages.

    Raises:
        UrdfError: not XML, not a URDF, not written by hsr_pin, or changed since (its bodies and joints are not those of the
            arm that its extension element declares).
    """
    tree = parse_xml(text, source)
    spec = _read_extension(tree)
    _check_unchanged(tree, parse_xml(arm_to_urdf(spec)))
    return spec


def load_urdf(path: str | Path) -> ArmSpecification:
    """Read a file with :func:`urdf_to_arm`.

    Raises:
        UrdfError: as there, or the file cannot be read.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "bytes that are not UTF-8 text"
        raise UrdfError("cannot read the file", expected="a URDF written by hsr-urdf", received=reason, file=path) from error
    return urdf_to_arm(text, path)


def save_urdf(spec: ArmSpecification, path: str | Path) -> None:
    """Write :func:`arm_to_urdf` to a file, whole or not at all.

    Raises:
        OutputError: the file cannot be written.
    """
    write_text(path, arm_to_urdf(spec))


def _plain(value: Any) -> int | float | str:
    """Turn a number of numpy's into Python's own."""
    return value if isinstance(value, str) else int(value) if hasattr(value, "__index__") else float(value)


@lru_cache(maxsize=1)
def _template() -> Template:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # here: `--help` does without

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
    """Read a number, or pass on the text itself, which the specification then refuses by name."""
    try:
        return kind(text)
    except ValueError:
        return text


def _check_unchanged(tree: XmlTree, declared: XmlTree) -> None:
    """Compare all that moves and weighs, to 1e-9, with what the declared arm gives; looks are free to change."""
    got, wanted = _physics(tree.root), _physics(declared.root)
    for name in (*got, *wanted):
        element, value = got.get(name, (tree.root, "nothing"))
        expected = wanted[name][1] if name in wanted else "nothing"
        if not _same(value, expected):
            hint = "change the arm with hsr-urdf, not the file by hand"
            tree.fail(f"{name.strip()} does not fit the arm in <hsr>", element, expected=expected, received=value, hint=hint)


def _physics(root: Element) -> dict[str, tuple[Element, str]]:
    """Every attribute of links, joints and <hsr>, but for looks: "link link_1 inertial mass value" -> (element, text)."""
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
    """Equal as text, or as rows of numbers."""
    try:
        return a == b or all(math.isclose(float(x), float(y), rel_tol=1e-9) for x, y in zip(a.split(), b.split(), strict=True))
    except ValueError:
        return False
