"""``hsr-export``: hand the model on to MuJoCo, Gazebo, Drake, PyBullet and others."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import ARM_OPTIONS, arm_from, arm_options
from hsr_pin.cli.command import leave, run
from hsr_pin.cli.outputs import check_outputs, dataset_folder, force_option

if TYPE_CHECKING:
    from hsr_pin.export.file import Exported
    from hsr_pin.export.model import CorrectedModel

_EPILOG = "Example: hsr-diagnose sample --json found.json, then hsr-export --from found.json --to mjcf -o arm.xml"
#: What a result tells of the arm, and must not be told otherwise.
_TOLD = ("damping", "length", "mass", "diameter", "bending", "torsion")


@click.command(name="hsr-export", epilog=_EPILOG, context_settings={"max_content_width": 100})
@click.option("--to", "target", type=click.Choice(["mjcf", "urdf", "sdf"]), required=True, help="MuJoCo, URDF or SDF.")
@click.option("-o", "--output", metavar="FILE", required=True, help="Where to write it; a module may be written beside it.")
@click.option("--from", "result", metavar="RESULT.json", help="A result of hsr-fit --json or hsr-diagnose --json.")
@click.option("--dataset", metavar="DATASET", help="The recordings, for a result that does not tell what they declare.")
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="NAME:PARAM=VALUE",
    help="Add what the paper's model lacks, e.g. dry_friction:level=0.05; may be repeated.",
)
@click.option(
    "--mujoco", type=click.Choice(["3", "4"]), default="4", show_default=True, help="Major version that an MJCF file is for."
)
@arm_options
@force_option
def command(target: str, output: str, force: bool, **options: Any) -> None:
    """Hand a hybrid soft robot on to another simulator, with the effects that were found.

    From an arm (the options of hsr-urdf), or from a fit or a diagnosis (--from; with several declared stiffnesses say which by
    --keq). Prints what the file holds, what a module beside it does, and what neither can say.
    """
    from hsr_pin.export.file import module_path, write

    dataset = options["dataset"]
    read = [options["result"], None if dataset is None else dataset_folder(dataset)]
    check_outputs({"--output": output}, read=read, force=force)
    exported = _exported(_model(options), target, output, int(options["mujoco"]))
    if exported.module:  # only now is it known whether there is one
        check_outputs({"the module beside it": module_path(output)}, read=read, force=force)
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
            raise InputError("--dataset", expected="--from RESULT.json with it", received="none")
        return CorrectedModel(arm_from(given), effects, origin=("an arm as told by options",))
    from hsr_pin.export.document import read_result

    told = [name for name in _TOLD if name in given] + (["effect"] if effects else [])
    if told:
        hint = "the result tells the rest"
        raise InputError(
            "--from",
            expected="only --keq, --links, --placement, --mount, --tilt, --cross-tilt, --tip-mass with it",
            received=f"--{told[0]}",
            hint=hint,
        )
    arm = arm_from(given | ({"bending": "space"} if "cross_tilt" in given else {}))  # checks what was typed
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
    leave(run(command))
