"""Command ``hsr-view``: interactive page that shows recordings beside the model with sliders for its parameters."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import chain_from, chain_options
from hsr_pin.cli.command import Grouped, exit_process, run
from hsr_pin.cli.outputs import dataset_argument

if TYPE_CHECKING:
    from hsr_pin.view.session import Session
    from hsr_pin.view.settings import Settings


@click.command(name="hsr-view", cls=Grouped, epilog="Example: hsr-view sample", context_settings={"max_content_width": 100})
@dataset_argument
@chain_options
@click.option(
    "--from", "result", metavar="RESULT.json", help="Result of hsr-fit --json or hsr-diagnose --json; a button sets its values."
)
@click.option("--report", metavar="REPORT.html", help="Report of hsr-diagnose --html, to which the page links.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, metavar="N", help="Port of the page.  [default: any free port]")
@click.option("--open/--no-open", "opened", default=True, help="Open the page in the browser.  [default: open]")
def command(dataset: str, **options: Any) -> None:
    """Show recordings beside the model on a page, with sliders for stiffness, damping and every effect.

    The trial is simulated again while a slider moves. The page is served to this machine only, until Ctrl-C.
    """
    from hsr_pin.loopback import PageServer
    from hsr_pin.recordings.read import read_dataset
    from hsr_pin.view.page import Page
    from hsr_pin.view.session import Session

    content = None if options["report"] is None else _report(options["report"])
    session = Session.of(read_dataset(dataset), **chain_from(options))
    found = {} if options["result"] is None else _found(session, options["result"], dataset)
    server = None if content is None else PageServer(content)
    page = Page(session, found=found, report=server.address if server else "", port=options["port"])
    try:
        if server is not None:
            server.start()
        click.echo(f"{page.address}  (Ctrl-C ends)")
        if options["opened"]:
            import webbrowser

            webbrowser.open(page.address)
        while True:
            time.sleep(0.5)
    except KeyboardInterrupt:
        click.echo("")
    finally:
        page.stop()
        if server is not None:
            server.shutdown()
            server.server_close()


def _report(path: str) -> bytes:
    from pathlib import Path

    from hsr_pin.errors import InputError
    from hsr_pin.recordings.files import LARGEST_RESULT, read_bytes

    content = read_bytes(Path(path), LARGEST_RESULT)
    if b"<html" not in content[:2000].lower():
        raise InputError("--report", expected="a page written by hsr-diagnose --html", received="no HTML", file=path)
    return content


def _found(session: Session, result: str, dataset: str) -> dict[str, Settings]:
    """Return the settings of each trial according to a result."""
    from hsr_pin.export.document import read_result
    from hsr_pin.robot.specification import ArmSpecification
    from hsr_pin.view.settings import Settings

    found = {}
    for each in session.experiment.runs:
        declared = ArmSpecification.from_trial(session.experiment.dataset, each.trial)
        model = read_result(result, keq=declared.keq, dataset=dataset)
        # trials of the same stiffness may declare different dampings
        found[each.trial.name] = Settings.of(model, declared.keq, declared.damping, declared.mass)
    return found


def main() -> None:
    """Entry point of ``hsr-view``."""
    exit_process(run(command))
