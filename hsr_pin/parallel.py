"""Parallel execution of many tasks: in this process, in several processes, on a cluster, or in any executor.

All parallel code in hsr_pin takes a ``concurrent.futures.Executor`` (PEP 3148). Data that all tasks need is sent with each task
as one :class:`Shared` object, which each worker process unpickles only once.
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

from hsr_pin.collector import reduce_collections
from hsr_pin.errors import InputError, MissingDependencyError, WorkerError

T = TypeVar("T")

#: Number of times that tasks are submitted before lost worker processes raise an error.
_ATTEMPTS = 3
#: Largest number of processes that are started before there are tasks for them.
_STARTED_EARLY = 16
#: Time within which a scheduler must answer [s].
_TIMEOUT = 10
#: Modules that are loaded before the worker processes start: all that a fit calls.
_PRELOADED = ("hsr_pin.inference.fit_pool", "hsr_pin.diagnosis.where", "hsr_pin.simulation.warm")
_LOST = "hsr_pin: a worker process ended unexpectedly; its tasks are repeated"
#: A script without this word would run again in each worker process that imports it.
_GUARD = "__main__"
_ONE_PROCESS_ONLY = f'hsr_pin: functions of this script run in one process only; put its work under: if __name__ == "{_GUARD}":'


class Serial(Executor):
    """Executor that runs each task immediately in this process."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Run a task and return it as a finished future."""
        done: Future[Any] = Future()
        try:
            done.set_result(function(*arguments, **named))
        except Exception as error:
            done.set_exception(error)
        return done


class Shared(Generic[T]):
    """Object that many tasks need: pickled once, and unpickled once in each worker process."""

    def __init__(self, thing: T) -> None:
        self._packed = pickle.dumps(thing, protocol=pickle.HIGHEST_PROTOCOL)
        self._mark = hashlib.sha256(self._packed).hexdigest()

    def get(self) -> T:
        """Return the object; all calls in one process return the same one."""
        thing: T = _unpacked(self)
        return thing

    def __hash__(self) -> int:
        return hash(self._mark)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Shared) and self._mark == other._mark


class _Local(Shared[T]):
    """Variant of :class:`Shared` for tasks that run in this process: the object is not pickled."""

    def __init__(self, thing: T) -> None:
        self._thing, self._mark = thing, str(id(thing))

    def get(self) -> T:
        """Return the object."""
        return self._thing


def with_shared(packed: Shared[Any], function: Callable[..., T], *arguments: Any) -> T:
    """Return ``function(thing, *arguments)`` for a shared thing; a task of :func:`run`."""
    return function(packed.get(), *arguments)


def shared(thing: T, executor: Executor) -> Shared[T]:
    """Wrap an object that many tasks of an executor need."""
    return _Local(thing) if isinstance(executor, Serial) else Shared(thing)


@lru_cache(maxsize=8)
def _unpacked(shared: Shared[Any]) -> Any:
    """Return the unpickled object of a :class:`Shared`."""
    return pickle.loads(shared._packed)


@contextmanager
def open_executor(jobs: int | None = None, cluster: str | None = None, executor: Executor | None = None) -> Iterator[Executor]:
    """Open an executor for the duration of a ``with`` block.

    Args:
        jobs: number of worker processes; default: one per core; 1: tasks run in this process.
        cluster: address of a Dask scheduler (``tcp://host:8786``) that runs the tasks instead of local processes.
        executor: executor to use instead; it stays open at the end of the block.

    Raises:
        InputError: the number of processes is less than one, or no scheduler answers at the address.
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
    """Return ``function(*task)`` for each task, in the order of the tasks; the first exception ends the run.

    Args:
        executor: executor that runs the tasks.
        function: a function that worker processes can import by name.
        tasks: the arguments of each call.
        advance: called after each finished task.

    Raises:
        WorkerError: worker processes ended unexpectedly several times in a row.
    """
    if isinstance(executor, Serial):
        return [_then(advance, function(*task)) for task in tasks]
    answers: dict[int, T] = {}
    for _ in range(_ATTEMPTS):
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
    raise WorkerError(_ATTEMPTS)


def start_task(executor: Executor, function: Callable[..., T], *arguments: Any) -> Callable[[], T]:
    """Submit ``function(*arguments)`` and return a function that waits for the result.

    If the worker process is lost, the task runs in this process.
    """
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
    """Report progress and return the answer unchanged."""
    advance()
    return answer


def prepare_workers(executor: Executor, function: Callable[..., None], *arguments: Any) -> None:
    """Run a preparatory function in each local worker process while this process prepares the tasks.

    Other executors ignore it: there the first task does the same preparation.
    """
    if isinstance(executor, _Pool):
        executor.submit_to_each(function, *arguments)


def for_each(
    work: Callable[[T], None],
    items: Sequence[T],
    *,
    jobs: int | None = 1,
    cluster: str | None = None,
    advance: Callable[[], None] = lambda: None,
) -> None:
    """Call ``work`` for each item, with ``jobs`` calls at a time or on a cluster; the first exception ends the loop."""
    few = jobs if jobs is None or cluster else max(1, min(jobs, len(items)))
    with open_executor(few, cluster) as executor:
        run(executor, work, [(item,) for item in items], advance)


class _Pool(Executor):
    """Pool of worker processes that end when this process ends, in whatever way.

    If one worker is lost, all workers are replaced. Workers do not import a main script without a guard, because it would run
    again; functions that such a script defines run in this process instead.
    """

    def __init__(self, count: int) -> None:
        self._count, self._importable, self._lock = count, _is_importable(sys.modules["__main__"]), threading.Lock()
        self._noticed = False
        self._worker_end, self._parent_end = multiprocessing.Pipe(duplex=False)
        self._pool = self._new_pool()

    def _new_pool(self) -> ProcessPoolExecutor:
        """Return a new pool of worker processes."""
        return ProcessPoolExecutor(self._count, _context(), initializer=_end_with_parent, initargs=(self._worker_end,))

    def submit_to_each(self, function: Callable[..., None], *arguments: Any) -> None:
        """Submit one task for each process in a background thread, so that the processes start now."""

        def begin() -> None:
            with suppress(RuntimeError, OSError):  # the pool is closed, or cannot start: later tasks report it
                for _ in range(min(self._count, _STARTED_EARLY)):
                    self.submit(function, *arguments)

        threading.Thread(target=begin, daemon=True).start()

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Submit a task, pickled immediately: the pool's own thread would pickle objects that this thread may be changing."""
        packed = pickle.dumps((function, arguments, named), protocol=pickle.HIGHEST_PROTOCOL)
        if not self._importable and _GUARD.encode() in packed:
            if not self._noticed:
                print(_ONE_PROCESS_ONLY, file=sys.stderr, flush=True)
                self._noticed = True
            return Serial().submit(function, *arguments, **named)
        with self._lock, _uninterrupted(), nullcontext() if self._importable else _not_imported(sys.modules["__main__"]):
            try:
                return self._pool.submit(_call, packed)
            except BrokenExecutor:
                _stop_sending(self._pool)
                self._pool.shutdown(wait=False, cancel_futures=True)
                self._pool = self._new_pool()
                return self._pool.submit(_call, packed)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes after their current tasks."""
        _stop_sending(self._pool)
        self._pool.shutdown(wait=wait, cancel_futures=cancel_futures)
        self.kill()

    def kill(self) -> None:
        """End the processes immediately."""
        self._parent_end.close()


def _is_importable(script: ModuleType) -> bool:
    """Return whether workers may import the main script: it is a module, or it has a ``__main__`` guard."""
    if getattr(script, "__spec__", None) is not None:
        return True
    try:
        return _GUARD in Path(script.__file__ or "").read_text(encoding="utf-8")
    except (AttributeError, OSError, UnicodeDecodeError):  # an interactive session, or a deleted file
        return False


@contextmanager
def _not_imported(script: ModuleType) -> Iterator[None]:
    """Prevent processes that start within the block from importing the script, by hiding its ``__file__``."""
    file = script.__dict__.pop("__file__", None)
    try:
        yield
    finally:
        if file is not None:
            script.__file__ = file


def _call(packed: bytes) -> Any:
    """Run a pickled task."""
    function, arguments, named = pickle.loads(packed)
    return function(*arguments, **named)


def _stop_sending(pool: ProcessPoolExecutor) -> None:
    """Drop tasks that are being sent to lost processes; Python before 3.11.5 would wait for them forever (gh-94777)."""
    private: Any = pool
    if sys.version_info < (3, 11, 5) and private._broken:
        with suppress(OSError):
            private._call_queue._reader.close()


def _context() -> BaseContext:
    """Return how worker processes start: forked from a single-threaded server that has loaded the modules, or else spawned."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    from multiprocessing import forkserver

    forkserver.set_forkserver_preload(list(_PRELOADED))
    with _uninterrupted():
        forkserver.ensure_running()  # the server loads the modules while this process loads them too
    return multiprocessing.get_context("forkserver")


def _end_with_parent(held: Connection) -> None:
    """Make a worker process end as soon as the parent closes its end of a pipe, or ends itself."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    reduce_collections()

    def follow() -> None:
        with suppress(EOFError, OSError):
            held.recv_bytes()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Block Ctrl-C and SIGTERM in processes that start within the block; this process receives them at the end of the block."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _is_loss(error: Exception) -> bool:
    """Return whether an error means a lost worker, of a pool or of a Dask cluster (whose error class is found by its name)."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    """Open an executor on a Dask cluster for the duration of a ``with`` block."""
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingDependencyError("distributed", "cluster") from error
    try:
        _check_listening(address)  # first, because a client that finds no scheduler may deadlock when it is garbage-collected
        client: Any = Client(address, timeout=_TIMEOUT)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError("cluster", expected="the address of a Dask scheduler that answers", received=address) from error
    with client:
        executor: Executor = client.get_executor(pure=False)
        yield executor


def _check_listening(address: str) -> None:
    """Check that a server listens at ``[tcp://]host:port``.

    Raises:
        OSError, ValueError: no server listens there, or the address is malformed.
    """
    protocol, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if protocol in ("", "tcp", "tls"):
        socket.create_connection((host.strip("[]"), int(port)), timeout=_TIMEOUT).close()
