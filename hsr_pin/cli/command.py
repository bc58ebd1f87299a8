"""Execution of the commands: exit code 0 with a result, or exit code 2 with one line on stderr and no traceback."""

from __future__ import annotations

import atexit
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from threading import Timer, current_thread, main_thread
from typing import ClassVar, NoReturn

import click

from hsr_pin.cli import IS_COMMAND
from hsr_pin.errors import HsrError, one_line

#: Exit code of a command after invalid input.
BAD_INPUT = 2
#: Exit code of an interrupted command (128 + SIGINT, by the convention of shells).
INTERRUPTED = 130
#: Time after which a signal that Python has dropped is sent again [s].
AGAIN = 0.01


class Grouped(click.Command):
    """Click command whose help lists the options in groups."""

    #: Title -> options of the group; all other options come first.
    GROUPS: ClassVar[dict[str, tuple[str, ...]]] = {
        "Trials": ("train", "test", "delay", "trial"),
        "Model": ("links", "placement", "effects", "max_effects", "dynamics"),
        "Arm": (
            "keq", "damping", "mount", "length", "mass", "diameter", "tip_mass", "tilt", "bending", "torsion", "cross_tilt"
        ),
        "Surroundings": ("ground", "wall", "post", "material"),
        "Output": (
            "json_file", "as_json", "html_file", "html", "plot_file", "plot", "urdf_file", "csv_folder", "replay", "live", "force"
        ),
        "Computation": ("jobs", "cluster", "seed"),
    }  # fmt: skip

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        title_of = {name: title for title, names in self.GROUPS.items() for name in names}
        found: dict[str, list[tuple[str, str]]] = {"Options": [], **{title: [] for title in self.GROUPS}}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                found[title_of.get(parameter.name or "", "Options")].append(record)
        for title, records in found.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


def run(command: click.Command, arguments: Sequence[str] | None = None) -> int:
    """Run a click command, and report any failure as one line and an exit code.

    Args:
        command: the command; its ``name`` precedes an error message.
        arguments: command-line arguments; None: those of this process.

    Returns:
        0; 2 after bad input (usage, a :class:`~hsr_pin.errors.HsrError`, an unreadable or unwritable file);
        130 after Ctrl-C.
    """
    _open_streams()
    with _interruptible():
        return _run(command, arguments)


def exit_process(code: int) -> NoReturn:
    """Exit the process; a command exits without unloading its modules, which would take a third of a second."""
    if not IS_COMMAND:
        sys.exit(code)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def _run(command: click.Command, arguments: Sequence[str] | None) -> int:
    try:
        given = list(sys.argv[1:] if arguments is None else arguments)
        with command.make_context(command.name, given) as context:
            code = command.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as end:  # --help and the like
        return end.exit_code
    except click.ClickException as error:
        return _print_error(command, error.format_message())
    except HsrError as error:
        return _print_error(command, str(error))
    except BrokenPipeError:  # the reader of the output has closed it, e.g. `| head`
        from hsr_pin.cli.console import discard_output

        discard_output()
        return 0
    except (KeyboardInterrupt, click.Abort):
        return _print_error(command, "interrupted", INTERRUPTED)
    except OSError as error:
        return _print_error(command, f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except Exception as error:
        if _caused_by_interrupt(error):
            return _print_error(command, "interrupted", INTERRUPTED)
        raise
    return code if isinstance(code, int) else 0


def _caused_by_interrupt(error: BaseException | None) -> bool:
    """Return whether an error was caused by Ctrl-C, which can be turned into other errors while modules are imported."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _print_error(command: click.Command, message: str, code: int = BAD_INPUT) -> int:
    click.echo(f"{command.name}: error: {one_line(message)}", err=True)
    return code


def _open_streams() -> None:
    """Redirect closed streams (``>&-``) to the null device, and escape characters that a stream cannot encode."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream = getattr(sys, name)
        if stream is None:  # in this order each stream gets its own file number, which a file could take otherwise
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115
        elif mode == "w" and getattr(stream, "errors", "") == "strict" and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


@contextmanager
def _interruptible() -> Iterator[None]:
    """Turn Ctrl-C into an exception within the context; before and after, ``hsr_pin.cli`` lets it end the process.

    SIGTERM is turned into an exception too, so that incomplete files are removed and workers end before this process.
    """
    wanted = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: _end} if current_thread() is main_thread() else {}
    handlers = {number: handler for number, handler in wanted.items() if signal.getsignal(number) is signal.SIG_DFL}
    for number, handler in handlers.items():
        signal.signal(number, handler)
    previous, sys.unraisablehook = sys.unraisablehook, _resend_signal
    try:
        yield
    finally:
        sys.unraisablehook = previous
        for number in handlers:
            signal.signal(number, signal.SIG_DFL)


def _end(number: int, _: object) -> None:
    raise SystemExit(128 + number)


def _resend_signal(lost: sys.UnraisableHookArgs) -> None:
    """Send a signal again that arrived during a callback of Python (such as a finaliser), where exceptions are dropped."""
    number = {KeyboardInterrupt: signal.SIGINT, SystemExit: signal.SIGTERM}.get(lost.exc_type)
    if number is None:
        sys.__unraisablehook__(lost)
    else:
        Timer(AGAIN, _send, [number]).start()


def _send(number: int) -> None:
    """Send a signal to the main thread of this process (Windows has no signals between threads)."""
    if sys.platform == "win32":
        signal.raise_signal(number)
    elif (thread := main_thread().ident) is not None:
        signal.pthread_kill(thread, number)
