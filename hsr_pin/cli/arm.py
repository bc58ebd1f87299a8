"""Command-line options that describe an arm, shared by several commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from hsr_pin.robot.specification import ArmSpecification

Command = TypeVar("Command", bound=Callable[..., Any])

#: Default number of links in every command, equal to that of fits and diagnoses (checked by a test).
LINKS = 16
#: Number of links of the paper's chain.
PAPER_LINKS = 4

#: Name -> placeholder, help, default. The defaults are those of ArmSpecification (checked by a test). They are repeated here
#: because importing that class imports numpy, which would delay ``--help``.
ARM_OPTIONS: dict[str, tuple[str, str, object]] = {
    "links": ("N", "Number N of links; the paper uses 4.", LINKS),
    "keq": ("X", "Bending stiffness of the arm [Nm/rad].", 1.11),
    "damping": ("X", "Damping C of the arm [Nm s/rad].", "the paper's for --keq"),
    "placement": (
        "WORD",
        "Joints at the base end (base) or in the middle (mid) of each element; shifted: mid, with a correction at both ends.",
        "base with 4 links, as in the paper; else mid",
    ),
    "mount": ("WORD", "Direction of the straight arm: hanging, upright, horizontal, or flat (horizontal plane).", "hanging"),
    "length": ("X", "Arc length of the backbone [m].", 0.24),
    "mass": ("X", "Mass of the arm [kg].", 0.15),
    "diameter": ("X", "Outer diameter [m].", 0.04),
    "tip_mass": ("X", "Point mass at the tip [kg].", 0.0),
    "tilt": ("X", "Rotation of the base from its mount towards positive bending [rad].", 0.0),
    "bending": ("WORD", "Bending in a plane (plane) or about two axes (space).", "plane"),
    "torsion": ("X", "Torsional stiffness in space [Nm/rad]; inf: no twist, 0: free twist.", math.inf),
    "cross_tilt": ("X", "Rotation of the base towards its side, in space [rad].", 0.0),
}


def arm_options(command: Command) -> Command:
    """Add the options ``--links`` to ``--cross-tilt`` to a command, which passes their values as text to :func:`arm_from`."""
    for name, (metavar, text, default) in reversed(ARM_OPTIONS.items()):
        option = f"--{name.replace('_', '-')}"
        command = click.option(option, name, metavar=metavar, help=f"{text}  [default: {default}]")(command)
    return command


def effect_option(command: Command) -> Command:
    """Add the option ``--effect`` to a command, which passes texts for :func:`hsr_pin.effects.parse_effect`."""
    text = "Add an effect to the paper's model, e.g. dry_friction:level=0.05; may be repeated."
    return click.option("--effect", "effects", multiple=True, metavar="NAME:PARAM=VALUE", help=text)(command)


def chain_options(command: Command) -> Command:
    """Add the options ``--links`` and ``--placement`` of the model chain to a command; see :func:`chain_from`."""
    own = "as simulated, else"
    placements = f"Placement of the joints of the model.  [default: {own} mid; base with --links 4]"
    placement = click.option("--placement", type=click.Choice(["mid", "base"]), help=placements)
    links = click.option(
        "--links", type=click.IntRange(1, 100), metavar="N", help=f"Number of links of the model.  [default: {own} {LINKS}]"
    )
    return links(placement(command))


def chain_from(options: dict[str, Any]) -> dict[str, Any]:
    """Return the keyword arguments ``links`` and ``placement``; None for options that were not given."""
    placement = options["placement"]
    if placement is None and options["links"] is not None:
        placement = placement_for(options["links"])
    return {"links": options["links"], "placement": placement}


def arm_from(options: dict[str, Any]) -> ArmSpecification:
    """Return the arm that the options describe; values that are not given are those of the paper.

    Raises:
        SpecificationError: a value is invalid.
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
    """Return the default placement of the joints: at the base ends of the paper's four links, otherwise in the middle."""
    return "base" if links == PAPER_LINKS else "mid"


def _value(name: str, text: str) -> Any:
    """Return a number from text, or the text itself if it is not a number, which the specification then refuses by name."""
    kind = str if ARM_OPTIONS[name][0] == "WORD" else int if name == "links" else float
    try:
        return kind(text)
    except ValueError:
        return text
