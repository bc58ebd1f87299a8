"""Initialisation of numba at import, for a process from which worker processes are forked."""

import numba

numba.njit("void()")(lambda: None)
