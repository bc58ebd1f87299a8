"""The same for many cases, perhaps side by side."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

from hsr_pin.errors import HsrError

T = TypeVar("T")


def for_each(work: Callable[[T], None], items: Sequence[T], jobs: int = 1, advance: Callable[[], None] = lambda: None) -> None:
    """Call ``work`` for each item, in this process or in ``jobs`` others; ``advance`` is called after each.

    The first exception ends it; what has been done by then stays done.
    """
    if jobs == 1 or len(items) < 2:
        for item in items:
            work(item)
            advance()
        return
    context = multiprocessing.get_context("spawn")  # forking a process that runs threads is not safe
    with ProcessPoolExecutor(min(jobs, len(items)), context) as executor:
        try:
            for future in as_completed([executor.submit(_work, work, item) for item in items]):
                future.result()
                advance()
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            raise


def _work(work: Callable[[T], None], item: T) -> None:
    try:
        work(item)
    except HsrError as error:
        raise HsrError(str(error)) from None  # those with more arguments than a text do not come through a pipe
