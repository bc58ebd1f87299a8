"""All that numba sets up before it can load machine code, done at import: for a process from which others are forked."""

import numba

numba.njit("void()")(lambda: None)
