"""The options that describe an arm, the same in every command that asks for one."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from hsr_pin.robot.specification import ArmSpecification

Command = TypeVar("Command", bound=Callable[..., Any])

#: Name -> placeholder, help, default. The defaults are those of ArmSpecification (a test compares them), repeated here because
#: loading it loads numpy, for which ``--help`` should not wait.
ARM_OPTIONS: dict[str, tuple[str, str, object]] = {
    "links": ("N", "Number N of links.", 4),
    "keq": ("X", "Bending stiffness of the arm [Nm/rad].", 1.11),
    "damping": ("X", "Damping C of the arm [Nm s/rad].", "the paper's for --keq"),
    "placement": (
        "WORD",
        "Joints at the base end (base) or in the middle (mid) of each element; shifted: mid, corrected at the ends.",
        "base",
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


def arm_from(options: dict[str, Any]) -> ArmSpecification:
    """Make the arm that the options describe; one that was not given is the paper's.

    Raises:
        SpecificationError: a value that an arm cannot have, in whatever way it is wrong.
    """
    from hsr_pin.robot.specification import ArmSpecification, default_damping

    values = {name: _value(name, options[name]) for name in ARM_OPTIONS if options.get(name) is not None}
    if "damping" in values:
        return ArmSpecification(**values)
    spec = ArmSpecification(**values)  # checks the stiffness before it is used
    return ArmSpecification(**values, damping=default_damping(spec.keq))


def _value(name: str, text: str) -> Any:
    """Read a number where one is meant, or pass on the text, which the specification then refuses by name."""
    kind = str if ARM_OPTIONS[name][0] == "WORD" else int if name == "links" else float
    try:
        return kind(text)
    except ValueError:
        return text
