"""A variant of numba's code cache that tolerates damaged files and a full disk."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

_REPORTED: set[str] = set()


def cached(decorate: Callable[..., Any], function: Callable[..., Any], **options: Any) -> tuple[Any, bool]:
    """Compile a function with one of numba's decorators; return it, and whether its machine code is cached on disk.

    The code is not cached if no cache folder is writable.
    """
    try:
        with _lenient():
            return decorate(cache=True, **options)(function), True
    except RuntimeError as error:
        if "cache" not in str(error):
            raise
        return decorate(**options)(function), False


@contextmanager
def _lenient() -> Iterator[None]:
    """Make numba's decorators use the cache class of :func:`_lenient_cache`; numba has no setting for it."""
    from numba.core import ccallback, dispatcher

    modules: tuple[Any, ...] = (ccallback, dispatcher)
    before = [module.FunctionCache for module in modules]
    try:
        for module in modules:
            module.FunctionCache = _lenient_cache()
        yield
    finally:
        for module, kind in zip(modules, before, strict=True):
            module.FunctionCache = kind


@cache
def _lenient_cache() -> Any:
    """Return a cache class that recompiles unreadable entries and works without a writable folder."""
    from numba.core.caching import FunctionCache

    class LenientCache(FunctionCache):  # type: ignore[misc]
        def load_overload(self, signature: Any, context: Any) -> Any:
            try:
                return super().load_overload(signature, context)
            except Exception:  # damaged bytes can raise any exception
                _report_once("damaged", f"the machine code in {self.cache_path} is damaged and is compiled again")
                with suppress(OSError):
                    self.flush()
                return None

        def save_overload(self, signature: Any, code: Any) -> None:
            try:
                super().save_overload(signature, code)
            except OSError as error:
                reason = (
                    f"cannot save machine code in {self.cache_path} ({error.strerror or error}), so every process compiles it"
                )
                _report_once("full", f"{reason}: free some space there, or set NUMBA_CACHE_DIR to another folder")

    return LenientCache


def _report_once(trouble: str, sentence: str) -> None:
    """Print a message on standard error, once per process for each kind of problem."""
    if trouble not in _REPORTED:
        _REPORTED.add(trouble)
        print(f"hsr_pin: {sentence}", file=sys.stderr, flush=True)
