"""The commands: parse, call, print. One file a command; ``*_report`` prints what it found, ``command`` ends it."""

import os
import sys

#: Whether this process is one of them, and no program that imports one.
IS_COMMAND = os.path.basename(sys.argv[0]).partition("-")[0] == "hsr"

try:
    from signal import SIG_DFL, SIGINT, default_int_handler, getsignal, signal

    if IS_COMMAND:
        if getsignal(SIGINT) is default_int_handler:
            signal(SIGINT, SIG_DFL)  # Ctrl-C ends a command that is still being loaded without a word; `command.run` takes over
        from hsr_pin.collector import spare

        spare()
except KeyboardInterrupt:
    sys.exit(130)
