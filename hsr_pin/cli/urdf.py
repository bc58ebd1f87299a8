"""Command ``hsr-urdf``: write an arm as a URDF."""

from __future__ import annotations

from typing import Any

import click

from hsr_pin.cli.arm import arm_from, arm_options
from hsr_pin.cli.command import exit_process, run
from hsr_pin.cli.outputs import check_outputs, force_option


@click.command(name="hsr-urdf")
@arm_options
@click.option("-o", "--output", metavar="FILE", help="File to write.  [default: standard output]")
@force_option
def command(output: str | None, force: bool, **arm: Any) -> None:
    """Write a hybrid soft robot as a URDF.

    The file loads in Pinocchio and in every other reader of URDF. Other readers ignore its extension element <hsr> with the
    springs, dampers and everything else that is needed to restore the same arm. The default is the paper's arm (Table I).
    """
    from hsr_pin.robot.urdf import arm_to_urdf, save_urdf  # imported here, as it imports the template engine

    spec = arm_from(arm)
    if output is None:
        click.echo(arm_to_urdf(spec), nl=False)
    else:
        check_outputs({"--output": output}, force=force)
        save_urdf(spec, output)


def main() -> None:
    """Entry point of ``hsr-urdf``."""
    exit_process(run(command))
