"""Command ``hsr``: all commands as subcommands of one."""

from __future__ import annotations

from importlib import import_module

import click

from hsr_pin.cli.command import exit_process, run

#: Command -> its module and a description.
COMMANDS = {
    "sim": ("sim", "Simulate the arm."),
    "urdf": ("urdf", "Write the arm as URDF."),
    "import": ("import_", "Convert motion capture files to a dataset."),
    "replay": ("replay", "Show a recording beside its simulation."),
    "fit": ("fit", "Fit stiffness, damping and more, with intervals."),
    "diagnose": ("diagnose", "Find which effect the model lacks, or what has changed."),
    "view": ("view", "Try stiffness, damping and effects beside a recording."),
    "export": ("export", "Write the corrected model for MuJoCo, URDF or SDF."),
    "blind": ("blind", "Check the diagnosis on recordings whose effect is withheld."),
}


class _Commands(click.Group):
    """Click group that imports each command only when it is called, which saves time."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        found: click.Command = import_module(f"hsr_pin.cli.{COMMANDS[cmd_name][0]}").command
        return found

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, what) for name, (_, what) in COMMANDS.items()])


@click.group(
    name="hsr",
    cls=_Commands,
    context_settings={"max_content_width": 100},
    epilog="Example: hsr diagnose sample",
    invoke_without_command=True,
)
@click.version_option(package_name="hsr_pin", prog_name="hsr_pin")
@click.pass_context
def command(context: click.Context) -> None:
    """Simulate hybrid soft robots, and find out which physics the model lacks.

    Each command has its own help: hsr diagnose --help. Each is also installed by its own name: hsr-diagnose.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main() -> None:
    """Entry point of ``hsr``."""
    exit_process(run(command))
