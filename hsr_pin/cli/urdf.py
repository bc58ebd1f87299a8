"""``hsr-urdf``: write the arm as a URDF."""

from __future__ import annotations

from typing import Any

import click

from hsr_pin.cli.arm import arm_from, arm_options
from hsr_pin.cli.command import leave, run
from hsr_pin.cli.outputs import check_outputs, force_option


@click.command(name="hsr-urdf")
@arm_options
@click.option("-o", "--output", metavar="FILE", help="Where to write it.  [default: standard output]")
@force_option
def command(output: str | None, force: bool, **arm: Any) -> None:
    """Write a hybrid soft robot as a URDF.

    It loads in Pinocchio and in every other reader of URDF; springs, dampers and all else that it takes to rebuild the very
    same arm stand in an extension element, <hsr>, that other readers ignore. Without options: the paper's arm, Table I.
    """
    from hsr_pin.robot.urdf import arm_to_urdf, save_urdf  # loads the template engine

    spec = arm_from(arm)
    if output is None:
        click.echo(arm_to_urdf(spec), nl=False)
    else:
        check_outputs({"--output": output}, force=force)
        save_urdf(spec, output)


def main() -> None:
    """Entry point of ``hsr-urdf``."""
    leave(run(command))
