"""The commands: parse, call, print. One file a command; ``*_report`` prints what it found, ``command`` ends it."""
