"""Where machine code is kept: in numba's own cache, which here may be damaged or full without a command ending over it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

_SAID: set[str] = set()


def cached(decorate: Callable[..., Any], function: Callable[..., Any], **options: Any) -> tuple[Any, bool]:
    """A function through one of numba's decorators, and whether its machine code is kept: not where there is no folder for it."""
    try:
        with _lenient():
            return decorate(cache=True, **options)(function), True
    except RuntimeError as error:
        if "cache" not in str(error):
            raise
        return decorate(**options)(function), False


@contextmanager
def _lenient() -> Iterator[None]:
    """Functions that numba's decorators make in here have a cache of :func:`_kind`; numba has no setting for it."""
    from numba.core import ccallback, dispatcher

    modules: tuple[Any, ...] = (ccallback, dispatcher)
    before = [module.FunctionCache for module in modules]
    try:
        for module in modules:
            module.FunctionCache = _kind()
        yield
    finally:
        for module, kind in zip(modules, before, strict=True):
            module.FunctionCache = kind


@cache
def _kind() -> Any:
    """A cache that is made anew where it cannot be read, and does without where it cannot be written."""
    from numba.core.caching import FunctionCache

    class LenientCache(FunctionCache):  # type: ignore[misc]
        def load_overload(self, signature: Any, context: Any) -> Any:
            try:
                return super().load_overload(signature, context)
            except Exception:  # whatever becomes of bytes that are no pickle
                _say("damaged", f"the machine code kept in {self.cache_path} is damaged, and is made anew")
                with suppress(OSError):
                    self.flush()
                return None

        def save_overload(self, signature: Any, code: Any) -> None:
            try:
                super().save_overload(signature, code)
            except OSError as error:
                reason = (
                    f"cannot keep machine code in {self.cache_path} ({error.strerror or error}), and makes it in every process"
                )
                _say("full", f"{reason}: make room there, or name another folder as NUMBA_CACHE_DIR")

    return LenientCache


def _say(trouble: str, sentence: str) -> None:
    """On standard error; of each trouble once in a process, wherever else it is met."""
    if trouble not in _SAID:
        _SAID.add(trouble)
        print(f"hsr_pin: {sentence}", file=sys.stderr, flush=True)
