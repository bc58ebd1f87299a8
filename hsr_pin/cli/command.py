"""How every command ends: a result and exit code 0, or one line on stderr and exit code 2. Never a traceback."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

from hsr_pin.errors import HsrError

#: Exit code of a command that was given something it cannot use.
BAD_INPUT = 2
#: Exit code of a command that was interrupted (128 + SIGINT, as shells have it).
INTERRUPTED = 130


def run(command: click.Command, arguments: Sequence[str] | None = None) -> int:
    """Carry out a click command and turn every way it can fail into one line and an exit code.

    Args:
        command: its ``name`` stands before the error.
        arguments: as on the command line; None: those of this process.

    Returns:
        0; 2 after bad input (usage, a :class:`~hsr_pin.errors.HsrError`, an unreadable or unwritable file);
        130 after Ctrl-C.
    """
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
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (KeyboardInterrupt, click.Abort):
        return _complain(command, "interrupted", INTERRUPTED)
    except OSError as error:
        return _complain(command, f"{error.filename}: {error.strerror}" if error.filename else str(error))
    return code if isinstance(code, int) else 0


def _complain(command: click.Command, message: str, code: int = BAD_INPUT) -> int:
    click.echo(f"{command.name}: error: {' '.join(message.split())}", err=True)
    return code
