"""Command-line interface: one file for each command; ``*_report`` prints its results, ``command`` handles its exit."""

import os
import sys

#: Whether this process is a command, and not a program that imports one.
IS_COMMAND = os.path.basename(sys.argv[0]).partition("-")[0] == "hsr"

try:
    from signal import SIG_DFL, SIGINT, default_int_handler, getsignal, signal

    if IS_COMMAND:
        if getsignal(SIGINT) is default_int_handler:
            signal(SIGINT, SIG_DFL)  # Ctrl-C ends a command silently while it loads; `command.run` takes over
        from hsr_pin.collector import reduce_collections

        reduce_collections()
except KeyboardInterrupt:
    sys.exit(130)
