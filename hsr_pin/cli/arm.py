"""The options that describe an arm, the same in every command that asks for one."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from hsr_pin.robot.specification import ArmSpecification

Command = TypeVar("Command", bound=Callable[..., Any])

#: Links of the chain where none are asked for, in every command: as fits and diagnoses have (a test compares them).
LINKS = 16
#: Links of the paper's chain.
PAPER_LINKS = 4

#: Name -> placeholder, help, default. The others are those of ArmSpecification (a test compares them), repeated here because
#: loading it loads numpy, for which ``--help`` should not wait.
ARM_OPTIONS: dict[str, tuple[str, str, object]] = {
    "links": ("N", "Number N of links; the paper has 4.", LINKS),
    "keq": ("X", "Bending stiffness of the arm [Nm/rad].", 1.11),
    "damping": ("X", "Damping C of the arm [Nm s/rad].", "the paper's for --keq"),
    "placement": (
        "WORD",
        "Joints at the base end (base) or in the middle (mid) of each element; shifted: mid, corrected at the ends.",
        "base with 4 links, as in the paper; else mid",
    ),
    "mount": ("WORD", "Where the straight arm points: hanging, upright or horizontal.", "hanging"),
    "length": ("X", "Arc length of the backbone [m].", 0.24),
    "mass": ("X", "Mass of the arm [kg].", 0.15),
    "diameter": ("X", "Outer diameter [m].", 0.04),
    "tip_mass": ("X", "Point mass at the tip [kg].", 0.0),
    "tilt": ("X", "Turn of the base from its mount, towards positive bending [rad].", 0.0),
    "bending": ("WORD", "In a plane (plane) or about two axes (space).", "plane"),
    "torsion": ("X", "Stiffness against twisting, in space [Nm/rad]; inf: none, 0: freely.", math.inf),
    "cross_tilt": ("X", "Turn of the base towards its side, in space [rad].", 0.0),
}


def arm_options(command: Command) -> Command:
    """Give a command ``--links`` to ``--cross-tilt``; it passes their values, by name and as typed, to :func:`arm_from`."""
    for name, (metavar, text, default) in reversed(ARM_OPTIONS.items()):
        option = f"--{name.replace('_', '-')}"
        command = click.option(option, name, metavar=metavar, help=f"{text}  [default: {default}]")(command)
    return command


def chain_options(command: Command) -> Command:
    """Give a command ``--links`` and ``--placement`` of the chain that models recordings; see :func:`chain_from`."""
    own = "that which simulated the recordings, else"
    placement = click.option(
        "--placement", type=click.Choice(["mid", "base"]), help=f"Of its joints.  [default: {own} mid; base with --links 4]"
    )
    links = click.option(
        "--links", type=click.IntRange(1, 100), metavar="N", help=f"Links of the model.  [default: {own} {LINKS}]"
    )
    return links(placement(command))


def chain_from(options: dict[str, Any]) -> dict[str, Any]:
    """The keyword arguments ``links`` and ``placement``; None where nothing was said."""
    placement = options["placement"]
    if placement is None and options["links"] is not None:
        placement = placement_for(options["links"])
    return {"links": options["links"], "placement": placement}


def arm_from(options: dict[str, Any]) -> ArmSpecification:
    """Make the arm that the options describe; one that was not given is the paper's.

    Raises:
        SpecificationError: a value that an arm cannot have, in whatever way it is wrong.
    """
    from hsr_pin.robot.specification import ArmSpecification, default_damping

    values = {name: _value(name, options[name]) for name in ARM_OPTIONS if options.get(name) is not None}
    values.setdefault("links", LINKS)
    values.setdefault("placement", placement_for(values["links"]))
    if "damping" in values:
        return ArmSpecification(**values)
    spec = ArmSpecification(**values)  # checks the stiffness before it is used
    return ArmSpecification(**values, damping=default_damping(spec.keq))


def placement_for(links: object) -> str:
    """Where the joints of a chain are if nothing is said: at the base ends of the paper's four links, in the middle of others."""
    return "base" if links == PAPER_LINKS else "mid"


def _value(name: str, text: str) -> Any:
    """Read a number where one is meant, or pass on the text, which the specification then refuses by name."""
    kind = str if ARM_OPTIONS[name][0] == "WORD" else int if name == "links" else float
    try:
        return kind(text)
    except ValueError:
        return text
