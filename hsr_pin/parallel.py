"""The same done to many things side by side: in this process, in several, or on a cluster, through any Executor.

Everything in hsr_pin that works side by side takes a ``concurrent.futures.Executor`` (PEP 3148). What all tasks need is sent to
each worker with them as one :class:`Shared` object, and unpacked there once.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import pickle
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager, nullcontext, suppress
from functools import lru_cache
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from pathlib import Path
from types import ModuleType
from typing import Any, Generic, TypeVar

from hsr_pin.collector import spare
from hsr_pin.errors import InputError, MissingDependencyError, WorkerError

T = TypeVar("T")

#: How often work is begun anew whose worker was lost.
_TRIES = 3
#: So many processes at most are begun before there is work for them.
_EARLY = 16
#: A scheduler answers within this time [s].
_PATIENCE = 10
#: What processes of our own are begun with: all that a fit will call.
_PRELOADED = ("hsr_pin.inference.fit_pool", "hsr_pin.diagnosis.where", "hsr_pin.simulation.warm")
_LOST = "hsr_pin: a worker process was lost; its work is done again"
#: A script without this word does its work when a worker imports it.
_GUARD = "__main__"
_HERE = f'hsr_pin: what this script defines is computed in one process; put its work under: if __name__ == "{_GUARD}":'


class Serial(Executor):
    """Does each task at once, in this process."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """The finished task."""
        done: Future[Any] = Future()
        try:
            done.set_result(function(*arguments, **named))
        except Exception as error:
            done.set_exception(error)
        return done


class Shared(Generic[T]):
    """Something that many tasks need: pickled once, unpacked once by each process that it reaches."""

    def __init__(self, thing: T) -> None:
        self._packed = pickle.dumps(thing, protocol=pickle.HIGHEST_PROTOCOL)
        self._mark = hashlib.sha256(self._packed).hexdigest()

    def get(self) -> T:
        """The thing, the same object at every call in one process."""
        thing: T = _unpacked(self)
        return thing

    def __hash__(self) -> int:
        return hash(self._mark)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Shared) and self._mark == other._mark


class Held(Shared[T]):
    """The same for tasks that this process does itself: nothing is packed."""

    def __init__(self, thing: T) -> None:
        self._thing, self._mark = thing, str(id(thing))

    def get(self) -> T:
        """The thing."""
        return self._thing


def shared(thing: T, executor: Executor) -> Shared[T]:
    """Something that many tasks of an executor need."""
    return Held(thing) if isinstance(executor, Serial) else Shared(thing)


@lru_cache(maxsize=8)
def _unpacked(shared: Shared[Any]) -> Any:
    return pickle.loads(shared._packed)


@contextmanager
def workers(jobs: int | None = None, cluster: str | None = None, executor: Executor | None = None) -> Iterator[Executor]:
    """An executor for the time of a ``with`` block.

    Args:
        jobs: processes; default: one per core. 1: this process alone.
        cluster: address of a Dask scheduler (``tcp://host:8786``), instead of processes here.
        executor: in place of both; it is not ended.

    Raises:
        InputError: a number of processes that is none, or no scheduler at the address.
        MissingDependencyError: dask.distributed is not installed.
    """
    if executor is not None:
        yield executor
        return
    if cluster is not None:
        with _dask(cluster) as executor:
            yield executor
        return
    count = os.cpu_count() or 1 if jobs is None else jobs
    if count < 1:
        raise InputError("jobs", expected="one or more", received=jobs)
    if count == 1:
        yield Serial()
        return
    pool = _Pool(count)
    try:
        yield pool
    except BaseException:
        pool.kill()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def run(
    executor: Executor, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], advance: Callable[[], None] = lambda: None
) -> list[T]:
    """``function(*task)`` for each task, in their order; the first exception ends it.

    Args:
        executor: who does it.
        function: importable by name.
        tasks: its arguments.
        advance: called after each answer.

    Raises:
        WorkerError: workers were lost again and again.
    """
    if isinstance(executor, Serial):
        return [_then(advance, function(*task)) for task in tasks]
    answers: dict[int, T] = {}
    for _ in range(_TRIES):
        futures = {executor.submit(function, *task): n for n, task in enumerate(tasks) if n not in answers}
        for future in as_completed(futures):
            try:
                answers[futures[future]] = _then(advance, future.result())
            except Exception as error:
                if not _is_loss(error):
                    raise
        if len(answers) == len(tasks):
            return [answers[n] for n in range(len(tasks))]
        print(_LOST, file=sys.stderr, flush=True)
    raise WorkerError(_TRIES)


def begun(executor: Executor, function: Callable[..., T], *arguments: Any) -> Callable[[], T]:
    """Begin ``function(*arguments)`` beside other tasks, and what waits for its answer; done here if its worker is lost."""
    future = executor.submit(function, *arguments)

    def answer() -> T:
        try:
            return future.result()
        except Exception as error:
            if not _is_loss(error):
                raise
            return function(*arguments)

    return answer


def _then(advance: Callable[[], None], answer: T) -> T:
    advance()
    return answer


def beforehand(executor: Executor, function: Callable[..., None], *arguments: Any) -> None:
    """Let each process of our own do something while this one gets their work ready; elsewhere the work itself asks for it."""
    if isinstance(executor, _Pool):
        executor.everywhere(function, *arguments)


def for_each(
    work: Callable[[T], None],
    items: Sequence[T],
    *,
    jobs: int | None = 1,
    cluster: str | None = None,
    advance: Callable[[], None] = lambda: None,
) -> None:
    """Call ``work`` for each item, ``jobs`` at a time or on a cluster; what was done before an exception ends it stays done."""
    few = jobs if jobs is None or cluster else max(1, min(jobs, len(items)))
    with workers(few, cluster) as executor:
        run(executor, work, [(item,) for item in items], advance)


class _Pool(Executor):
    """Processes that end with this one, however it ends; after the loss of one all are replaced by new ones.

    They do not import a script that would begin its work again. What it defines is then out of their reach, and done here.
    """

    def __init__(self, count: int) -> None:
        self._count, self._importable, self._lock = count, _is_importable(sys.modules["__main__"]), threading.Lock()
        self._noticed = False
        self._held, self._leash = multiprocessing.Pipe(duplex=False)
        self._pool = self._begun()

    def _begun(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._count, _context(), initializer=_follow, initargs=(self._held,))

    def everywhere(self, function: Callable[..., None], *arguments: Any) -> None:
        """A task for each of the processes, which are begun for it; nobody waits until they are."""

        def begin() -> None:
            with suppress(RuntimeError, OSError):  # all was over before they began, or they cannot: then the work itself tells
                for _ in range(min(self._count, _EARLY)):
                    self.submit(function, *arguments)

        threading.Thread(target=begin, daemon=True).start()

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """A task for one of the processes, packed here and now: another thread would pack what this one may be changing."""
        packed = pickle.dumps((function, arguments, named), protocol=pickle.HIGHEST_PROTOCOL)
        if not self._importable and _GUARD.encode() in packed:
            if not self._noticed:
                print(_HERE, file=sys.stderr, flush=True)
                self._noticed = True
            return Serial().submit(function, *arguments, **named)
        with self._lock, _uninterrupted(), nullcontext() if self._importable else _nameless(sys.modules["__main__"]):
            try:
                return self._pool.submit(_call, packed)
            except BrokenExecutor:
                _stop_sending(self._pool)
                self._pool.shutdown(wait=False, cancel_futures=True)
                self._pool = self._begun()
                return self._pool.submit(_call, packed)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when they have done what they are at."""
        _stop_sending(self._pool)
        self._pool.shutdown(wait=wait, cancel_futures=cancel_futures)
        self.kill()

    def kill(self) -> None:
        """End the processes at once."""
        self._leash.close()


def _is_importable(script: ModuleType) -> bool:
    """Whether a worker may import what this process runs: a module, or a script that does its work under a guard."""
    if getattr(script, "__spec__", None) is not None:
        return True
    try:
        return _GUARD in Path(script.__file__ or "").read_text(encoding="utf-8")
    except (AttributeError, OSError, UnicodeDecodeError):  # typed in, or gone
        return False


@contextmanager
def _nameless(script: ModuleType) -> Iterator[None]:
    """Processes that are begun within do not import the script: multiprocessing knows it by its file."""
    file = script.__dict__.pop("__file__", None)
    try:
        yield
    finally:
        if file is not None:
            script.__file__ = file


def _call(packed: bytes) -> Any:
    """Do a task that was packed."""
    function, arguments, named = pickle.loads(packed)
    return function(*arguments, **named)


def _stop_sending(pool: ProcessPoolExecutor) -> None:
    """Give up what is on its way to processes that were lost: Python before 3.11.5 would wait for it for ever (gh-94777)."""
    private: Any = pool
    if sys.version_info < (3, 11, 5) and private._broken:
        with suppress(OSError):
            private._call_queue._reader.close()


def _context() -> BaseContext:
    """How processes begin: forked from one that has loaded what they will want, and runs no threads; else each from nothing."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    from multiprocessing import forkserver

    forkserver.set_forkserver_preload(list(_PRELOADED))
    with _uninterrupted():
        forkserver.ensure_running()  # it loads while this process does the same
    return multiprocessing.get_context("forkserver")


def _follow(held: Connection) -> None:
    """In a worker: end as soon as the other end of a pipe is closed, by the process that began it or by that one's end."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    spare()

    def follow() -> None:
        with suppress(EOFError, OSError):
            held.recv_bytes()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Processes that are begun within leave Ctrl-C to this one, which hears of it, and of its end, when they are begun."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _is_loss(error: Exception) -> bool:
    """Whether a task ended because its worker did: of a pool, or of a Dask cluster (whose error has no common root)."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingDependencyError("distributed", "cluster") from error
    try:
        _knock(address)  # a client that found nobody is closed when it is collected, and may wait for itself then
        client: Any = Client(address, timeout=_PATIENCE)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError("cluster", expected="the address of a Dask scheduler that answers", received=address) from error
    with client:
        executor: Executor = client.get_executor(pure=False)
        yield executor


def _knock(address: str) -> None:
    """See that somebody listens at ``[tcp://]host:port``.

    Raises:
        OSError, ValueError: nobody does, or that is no address.
    """
    protocol, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if protocol in ("", "tcp", "tls"):
        socket.create_connection((host.strip("[]"), int(port)), timeout=_PATIENCE).close()
