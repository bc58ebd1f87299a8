"""How every command ends: a result and exit code 0, or one line on stderr and exit code 2. Never a traceback."""

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

#: Exit code of a command that was given something it cannot use.
BAD_INPUT = 2
#: Exit code of a command that was interrupted (128 + SIGINT, as shells have it).
INTERRUPTED = 130
#: After which time a signal that Python has dropped is sent again [s].
AGAIN = 0.01


class Grouped(click.Command):
    """A command whose help lists its options in groups."""

    #: Title -> the options under it; all others come first.
    GROUPS: ClassVar[dict[str, tuple[str, ...]]] = {
        "Trials": ("train", "test", "delay", "trial"),
        "Model": ("links", "placement", "effects", "max_effects", "dynamics"),
        "Arm": (
            "keq", "damping", "mount", "length", "mass", "diameter", "tip_mass", "tilt", "bending", "torsion", "cross_tilt"
        ),
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
    """Carry out a click command and turn every way it can fail into one line and an exit code.

    Args:
        command: its ``name`` stands before the error.
        arguments: as on the command line; None: those of this process.

    Returns:
        0; 2 after bad input (usage, a :class:`~hsr_pin.errors.HsrError`, an unreadable or unwritable file);
        130 after Ctrl-C.
    """
    _open_streams()
    with _interruptible():
        return _run(command, arguments)


def leave(code: int) -> NoReturn:
    """End this process; a command at once, for to take down all that it has loaded takes a third of a second."""
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
        return _complain(command, error.format_message())
    except HsrError as error:
        return _complain(command, str(error))
    except BrokenPipeError:  # the reader of our output has seen enough, e.g. `| head`
        from hsr_pin.cli.console import silence

        silence()
        return 0
    except (KeyboardInterrupt, click.Abort):
        return _complain(command, "interrupted", INTERRUPTED)
    except OSError as error:
        return _complain(command, f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except Exception as error:
        if _comes_of_interrupt(error):
            return _complain(command, "interrupted", INTERRUPTED)
        raise
    return code if isinstance(code, int) else 0


def _comes_of_interrupt(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind an error: while modules are loaded, Python and they turn it into others."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _complain(command: click.Command, message: str, code: int = BAD_INPUT) -> int:
    click.echo(f"{command.name}: error: {one_line(message)}", err=True)
    return code


def _open_streams() -> None:
    """Let streams that were closed (``>&-``) lead nowhere, and let none fail over a sign that it does not have."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream = getattr(sys, name)
        if stream is None:  # opened in this order, each gets its own number back, which a file could take otherwise
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115
        elif mode == "w" and getattr(stream, "errors", "") == "strict" and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


@contextmanager
def _interruptible() -> Iterator[None]:
    """Ctrl-C is an exception in here, where ``hsr_pin.cli`` has let it end the process so far, and again afterwards.

    So is SIGTERM: what is half done is taken away, and workers end before this process does.
    """
    wanted = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: _end} if current_thread() is main_thread() else {}
    handlers = {number: handler for number, handler in wanted.items() if signal.getsignal(number) is signal.SIG_DFL}
    for number, handler in handlers.items():
        signal.signal(number, handler)
    told, sys.unraisablehook = sys.unraisablehook, _heard
    try:
        yield
    finally:
        sys.unraisablehook = told
        for number in handlers:
            signal.signal(number, signal.SIG_DFL)


def _end(number: int, _: object) -> None:
    raise SystemExit(128 + number)


def _heard(lost: sys.UnraisableHookArgs) -> None:
    """Send a signal again that came while Python called back (a module's lock was freed, an object deleted): it drops those."""
    number = {KeyboardInterrupt: signal.SIGINT, SystemExit: signal.SIGTERM}.get(lost.exc_type)
    if number is None:
        sys.__unraisablehook__(lost)
    else:
        Timer(AGAIN, _send, [number]).start()


def _send(number: int) -> None:
    """Send this process a signal so that its main thread wakes up (Windows has no signals between threads)."""
    if sys.platform == "win32":
        signal.raise_signal(number)
    elif (thread := main_thread().ident) is not None:
        signal.pthread_kill(thread, number)
