"""Command ``hsr-export``: export the model to MuJoCo, Gazebo, Drake, PyBullet and others."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import ARM_OPTIONS, arm_from, arm_options, effect_option
from hsr_pin.cli.command import exit_process, run
from hsr_pin.cli.outputs import check_outputs, dataset_folder, force_option

if TYPE_CHECKING:
    from hsr_pin.export.file import Exported
    from hsr_pin.export.model import CorrectedModel

_EPILOG = "Example: hsr-diagnose sample --json found.json, then hsr-export --from found.json --to mjcf -o arm.xml"
#: Properties of the arm that a result determines, and that options must not change.
_FROM_RESULT = ("damping", "length", "mass", "diameter", "bending", "torsion")


@click.command(name="hsr-export", epilog=_EPILOG, context_settings={"max_content_width": 100})
@click.option("--to", "target", type=click.Choice(["mjcf", "urdf", "sdf"]), required=True, help="Format; mjcf is that of MuJoCo.")
@click.option("-o", "--output", metavar="FILE", required=True, help="File to write, possibly with a Python module.")
@click.option("--from", "result", metavar="RESULT.json", help="Result of hsr-fit --json or hsr-diagnose --json.")
@click.option("--dataset", metavar="DATASET", help="Recordings, for a result that does not contain their declaration.")
@effect_option
@click.option(
    "--mujoco", type=click.Choice(["3", "4"]), default="4", show_default=True, help="Major version of MuJoCo for an MJCF file."
)
@arm_options
@force_option
def command(target: str, output: str, force: bool, **options: Any) -> None:
    """Export a hybrid soft robot to another simulator, with the effects that were found.

    The model is an arm (the options of hsr-urdf), or the result of a fit or a diagnosis (--from; with several declared
    stiffnesses, choose one by --keq). The command prints which effects the file contains, which ones a Python module beside it
    applies, and which ones neither can express.
    """
    from hsr_pin.export.file import module_path, write

    dataset = options["dataset"]
    read = [options["result"], None if dataset is None else dataset_folder(dataset)]
    check_outputs({"--output": output}, read=read, force=force)
    exported = _exported(_model(options), target, output, int(options["mujoco"]))
    if exported.module:  # checked now, as only the export determines whether there is a module
        check_outputs({"the module beside the file": module_path(output)}, read=read, force=force)
    for path in write(exported, output):
        click.echo(f"wrote {path}")
    for title, lines in (
        ("needs", exported.needs),
        ("holds", exported.held),
        ("beside it", exported.by_module),
        ("not in it", exported.missing),
    ):
        for line in lines:
            click.echo(f"{title + ':':<10} {line}")


def _model(options: dict[str, Any]) -> CorrectedModel:
    from hsr_pin.effects.catalogue import parse_effect
    from hsr_pin.errors import InputError
    from hsr_pin.export.model import CorrectedModel

    given = {name: options[name] for name in ARM_OPTIONS if options[name] is not None}
    effects = tuple(parse_effect(text) for text in options["effects"])
    if options["result"] is None:
        if options["dataset"] is not None:
            raise InputError("--dataset", expected="--from RESULT.json together with this option", received="none")
        return CorrectedModel(arm_from(given), effects, origin=("an arm described by options",))
    from hsr_pin.export.document import read_result

    given_twice = [name for name in _FROM_RESULT if name in given] + (["effect"] if effects else [])
    if given_twice:
        hint = "the result determines the rest"
        raise InputError(
            "--from",
            expected="only --keq, --links, --placement, --mount, --tilt, --cross-tilt, --tip-mass with this option",
            received=f"--{given_twice[0]}",
            hint=hint,
        )
    arm = arm_from(given | ({"bending": "space"} if "cross_tilt" in given else {}))  # checks the options
    changes = {name: getattr(arm, name) for name in given if name != "keq"}
    keq = arm.keq if "keq" in given else None
    return read_result(options["result"], keq=keq, dataset=options["dataset"], changes=changes)


def _exported(model: CorrectedModel, target: str, output: str, major: int) -> Exported:
    if target == "mjcf":
        from hsr_pin.export.file import module_path
        from hsr_pin.export.mjcf import to_mjcf

        return to_mjcf(model, laws=module_path(output).stem, major=major)
    if target == "urdf":
        from hsr_pin.export.urdf import to_urdf

        return to_urdf(model)
    from hsr_pin.export.sdf import to_sdf

    return to_sdf(model)


def main() -> None:
    """Entry point of ``hsr-export``."""
    exit_process(run(command))
