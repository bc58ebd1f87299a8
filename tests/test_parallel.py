"""Results do not depend on the executor; lost workers are replaced, and workers end with their parent."""

import operator
import os
import pickle
import signal
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import BrokenExecutor, Executor, Future

import numpy as np
import pytest

from hsr_pin import parallel
from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.document import to_json
from hsr_pin.effects import EFFECTS, effect_named
from hsr_pin.errors import EffectError, InputError, MissingDependencyError, WorkerError
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part
from hsr_pin.inference.candidate import candidate
from hsr_pin.inference.fit import fit
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.parallel import Serial, Shared, for_each, open_executor, prepare_workers, run, start_task
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Pose, Scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Marker

from .filmed import filmed

#: How the main modules of the scripts begin: tasks for workers, and a thread that kills one of them.
HEAD = """
import multiprocessing, os, signal, sys, threading, time
from hsr_pin.cli.command import run as carried_out
from hsr_pin.parallel import open_executor, run

def square(number, seconds):
    time.sleep(seconds)
    return number * number

def die(number):
    os.kill(os.getpid(), signal.SIGKILL)

def killer(children, later):
    while len(children()) < 2:
        time.sleep(0.001)
    time.sleep(later)
    os.kill(children()[0].pid, signal.SIGKILL)
"""
LOST = "hsr_pin: a worker process ended unexpectedly; its tasks are repeated"


@pytest.fixture
def script(tmp_path):
    """Return a function that starts a script with this text as a process, in a process group of its own."""
    begun = []

    def begin(text, *arguments):
        path = tmp_path / "main.py"
        path.write_text(HEAD + text, encoding="utf-8")
        command = [sys.executable, "-W", "error", str(path), *map(str, arguments)]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, cwd=tmp_path
        )
        begun.append(process)
        return process

    yield begin
    for process in begun:
        if process.poll() is None:
            process.kill()
        process.communicate()


@pytest.fixture(scope="module")
def cluster():
    """Address of a local scheduler with two worker processes."""
    distributed = pytest.importorskip("distributed", reason="needs dask.distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0", host="127.0.0.1"
    ) as local:
        yield local.scheduler_address


@pytest.fixture(scope="module")
def released():
    """Three releases, whose initial pose is fitted again for every model."""
    time, markers = 0.02 * np.arange(41), (Marker("base", 0.0), Marker("mid", 0.12), Marker("tip", 0.24))
    arm, friction = ArmSpecification(links=10, placement="mid"), (EFFECTS["dry_friction"](0.03),)
    bent = [Pose(np.full(10, bend / 10)) for bend in (0.5, 0.8, -0.6)]
    motions = [simulate(Scenario(arm, time, np.zeros(41), pose, friction, markers)).trajectory for pose in bent]
    return Dataset("released", 0.24, 0.15, 0.04, "hanging", filmed(motions, 2e-4, 0, driven=False))


def found(executor, dataset):
    """Return the fitted values of a few effects, to the last digit."""
    experiment = prepare(dataset)
    base = fit(experiment, Hypothesis(links=6))
    pool = FitPool(experiment, executor)
    parts = [Part(name, EFFECTS[name]()) for name in ("dry_friction", "stiffness_gradient")]
    (proposals,) = pool.propose([(candidate(experiment, base, {}), parts)])
    fits = pool.quick([(base, proposal) for proposal in proposals])
    return [(c.fit.named, [h.tobytes() for h in c.heldout]) for c in pool.full(fits)]


def test_answers_are_equal_to_the_last_digit_in_this_process_in_two_others_and_on_a_cluster(released, cluster):
    alone = found(Serial(), released)
    assert len(alone) == 2
    with open_executor(2) as executor:
        assert found(executor, released) == alone
    with open_executor(cluster=cluster) as executor:
        assert found(executor, released) == alone


def test_fits_that_take_longest_begin_first_and_candidates_come_as_they_were_asked_for(released):
    class Noting(Executor):
        begun = ()

        def submit(self, function, /, *arguments, **named):
            self.begun += ([part.name for part in arguments[2].hypothesis.parts],)
            return Serial().submit(function, *arguments, **named)

    experiment, executor = prepare(released), Noting()
    models = [Hypothesis(links=6).with_part(Part(name, EFFECTS[name]())) for name in ("tip_mass", "dry_friction", "soft_spot")]
    starts = [fit(experiment, model, quick=True) for model in models]
    answers = FitPool(experiment, executor).full(starts)
    assert executor.begun == (["dry_friction"], ["soft_spot"], ["tip_mass"])
    assert [answer.fit.hypothesis for answer in answers] == models


def test_a_diagnosis_on_a_cluster_is_that_of_this_process(heavy_tip, cluster):
    asked = {"effects": ["tip_mass", "dead_time"], "max_effects": 1, "links": 6}
    alone, spread = (to_json(diagnose(heavy_tip, **asked, **where)) for where in ({"jobs": 1}, {"cluster": cluster}))
    assert spread == alone


def test_answers_come_in_the_order_of_the_tasks_and_each_advances_once(cluster):
    for given in ({"jobs": 1}, {"jobs": 2}, {"cluster": cluster}):
        calls = []
        with open_executor(**given) as executor:
            answers = run(executor, operator.mul, [(n, n) for n in range(20)], lambda calls=calls: calls.append(1))
        assert answers == [n * n for n in range(20)]
        assert len(calls) == 20


def test_a_diagnosis_takes_any_executor_and_leaves_it_open(heavy_tip):
    class Counting(Executor):
        tasks, ended = 0, False

        def submit(self, function, /, *arguments, **named):
            self.tasks += 1
            return Serial().submit(function, *arguments, **named)

        def shutdown(self, wait=True, *, cancel_futures=False):
            self.ended = True

    asked, given = {"effects": ["tip_mass"], "max_effects": 1, "links": 4}, Counting()
    assert to_json(diagnose(heavy_tip, **asked, executor=given)) == to_json(diagnose(heavy_tip, **asked, jobs=1))
    assert given.tasks > 0 and not given.ended


def test_processes_do_beforehand_what_each_of_them_needs(tmp_path):
    with open_executor(2) as executor:
        prepare_workers(executor, os.mkdir, tmp_path / "no" / "folder")  # what fails there fails when it is needed
        prepare_workers(executor, os.mkdir, tmp_path / "made")
        until = time.monotonic() + 30
        while not (tmp_path / "made").exists() and time.monotonic() < until:
            time.sleep(0.01)
        assert (tmp_path / "made").exists()
        assert run(executor, operator.mul, [(6, 7)]) == [42]
    prepare_workers(Serial(), os.mkdir, tmp_path / "elsewhere")
    assert not (tmp_path / "elsewhere").exists()


@pytest.mark.parametrize("module", ["hsr_pin.inference.fit_pool", "numba"])
def test_processes_begin_with_what_a_fit_calls(module):
    with open_executor(2) as executor:
        assert run(executor, eval, [(f"'{module}' in __import__('sys').modules",)]) == [True]


class Gone(Executor):
    """Executor that answers every task with an error."""

    def __init__(self, error):
        self.error = error

    def submit(self, function, /, *arguments, **named):
        answer = Future()
        answer.set_exception(self.error)
        return answer


def test_what_is_begun_beside_other_tasks_is_done_here_if_its_worker_is_lost():
    assert start_task(Serial(), operator.mul, 6, 7)() == 42
    assert start_task(Gone(BrokenExecutor()), operator.mul, 6, 7)() == 42
    with pytest.raises(ZeroDivisionError):
        start_task(Gone(ZeroDivisionError()), operator.mul, 6, 7)()


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_in_a_worker_arrives_as_it_was(jobs):
    with pytest.raises(EffectError, match="did you mean dry_friction") as caught, open_executor(jobs) as executor:
        run(executor, effect_named, [("dry_friction",), ("dry_frictions",)])
    assert (caught.value.subject, caught.value.received) == ("effect", "'dry_frictions'")


def test_errors_keep_their_facts_on_their_way():
    for error in (
        InputError("links", expected="one", received=0, file="a.toml", line=3),
        WorkerError(3),
        MissingDependencyError("x", "y"),
    ):
        copy = pickle.loads(pickle.dumps(error))
        assert type(copy) is type(error) and str(copy) == str(error) and vars(copy) == vars(error)


KILLED = """
if __name__ == "__main__":
    threading.Thread(target=killer, args=(multiprocessing.active_children, float(sys.argv[1])), daemon=True).start()
    with open_executor(2) as executor:
        print(run(executor, square, [(n, 0.6) for n in range(8)]))
"""


@pytest.mark.parametrize("later", [0.05, *(pytest.param(each, marks=pytest.mark.long) for each in (0.0, 0.3, 1.2))])
def test_a_worker_that_is_killed_at_once_or_later_costs_one_line_and_its_work_is_done_again(script, later):
    out, err = (process := script(KILLED, later)).communicate(timeout=60)
    assert (process.returncode, err.splitlines()) == (0, [LOST])
    assert out == f"{[n * n for n in range(8)]}\n"


LARGE = """
if __name__ == "__main__":
    threading.Thread(target=killer, args=(multiprocessing.active_children, 0.0), daemon=True).start()
    with open_executor(2) as executor:
        print([len(part) for part in run(executor, bytes, [(bytes(5_000_000),) for n in range(8)])])
"""


def test_a_worker_that_is_killed_while_it_is_sent_much_does_not_hang_the_others(script):
    out, err = (process := script(LARGE)).communicate(timeout=60)
    assert (process.returncode, err.splitlines()) == (0, [LOST])
    assert out == f"{[5_000_000] * 8}\n"


DYING = """
import click

@click.command(name="mortal")
def command():
    with open_executor(2) as executor:
        run(executor, die, [(n,) for n in range(3)])

if __name__ == "__main__":
    sys.exit(carried_out(command, []))
"""


def test_workers_that_die_every_time_are_given_up_in_one_more_line_and_exit_code_two(script):
    out, err = (process := script(DYING)).communicate(timeout=60)
    assert (process.returncode, out) == (2, "")
    *lines, last = err.splitlines()
    assert Counter(lines) == {LOST: len(lines)} and 2 <= len(lines) <= 3
    assert last.startswith("mortal: error: worker processes ended 3 times in a row")


LONG = """
if __name__ == "__main__":
    def tell():
        while len(multiprocessing.active_children()) < 2:
            time.sleep(0.01)
        time.sleep(float(sys.argv[1]))
        print(*[child.pid for child in multiprocessing.active_children()], flush=True)

    threading.Thread(target=tell, daemon=True).start()
    try:
        with open_executor(2) as executor:
            run(executor, square, [(n, 300.0) for n in range(4)])
    except KeyboardInterrupt:
        sys.exit(130)
"""


def ended(pids, within):
    """Return whether some processes end within a time [s]."""
    until = time.monotonic() + within
    while time.monotonic() < until:
        if not any(_lives(pid) for pid in pids):
            return True
        time.sleep(0.05)
    return False


def _lives(pid):
    try:
        os.kill(pid, 0)
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:  # where there is no such file, a zombie counts as alive
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except ProcessLookupError:
        return False
    except FileNotFoundError:
        return sys.platform != "linux"


@pytest.mark.parametrize("sort", [signal.SIGKILL, signal.SIGTERM])
@pytest.mark.parametrize("after", [pytest.param(0.0, marks=pytest.mark.long), 1.5])
def test_workers_end_with_the_process_that_began_them(script, sort, after):
    process = script(LONG, after)
    pids = [int(word) for word in process.stdout.readline().split()]
    assert len(pids) == 2 and all(map(_lives, pids))
    process.send_signal(sort)
    process.wait(timeout=10)
    assert ended(pids, 10)


@pytest.mark.long  # on a busy machine it has once not ended in 20 s
def test_ctrl_c_ends_the_workers_at_once_and_none_of_them_says_a_word(script):
    process = script(LONG, 1.5)
    pids = [int(word) for word in process.stdout.readline().split()]
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (130, "")
    assert ended(pids, 5)


def test_something_that_is_shared_is_unpacked_once_and_is_a_copy():
    thing = {"numbers": np.arange(3)}
    shared, same, other = Shared(thing), Shared(thing), Shared({})
    assert shared.get() is shared.get() is same.get() is pickle.loads(pickle.dumps(shared)).get()
    assert shared.get() is not thing and np.array_equal(shared.get()["numbers"], [0, 1, 2])
    assert shared == same != other and shared != thing


def test_for_each_does_every_item_and_stops_at_the_first_error(tmp_path):
    folders = [tmp_path / name for name in "abc"]
    for_each(os.mkdir, folders, jobs=2)
    assert all(folder.is_dir() for folder in folders)
    with pytest.raises(FileExistsError):
        for_each(os.mkdir, [tmp_path / "d", tmp_path / "a", tmp_path / "e"])
    assert (tmp_path / "d").exists() and not (tmp_path / "e").exists()
    for_each(os.mkdir, [])


@pytest.mark.parametrize("jobs", [0, -1])
def test_a_number_of_processes_that_is_none_is_refused(jobs):
    with pytest.raises(InputError, match="jobs: expected one or more"), open_executor(jobs):
        pass


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nowhere", "ftp://127.0.0.1:8786", ""])
def test_an_address_without_a_scheduler_is_refused(address, monkeypatch):
    pytest.importorskip("distributed", reason="needs dask.distributed")
    monkeypatch.setattr(parallel, "_TIMEOUT", 1)
    with (
        pytest.raises(InputError, match="cluster: expected the address of a Dask scheduler that answers"),
        open_executor(cluster=address),
    ):
        pass


def test_without_dask_the_group_that_brings_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingDependencyError, match=r"hsr_pin\[cluster\]"), open_executor(cluster="tcp://127.0.0.1:8786"):
        pass


def test_a_script_without_a_guard_does_its_work_in_processes_that_do_not_import_it(tmp_path):
    file = tmp_path / "script.py"
    file.write_text(
        "import os\n"
        "from hsr_pin.parallel import open_executor, run\n"
        "print('begun')\n"
        "def own(n):\n"
        "    return os.getpid(), n\n"
        "with open_executor(2) as executor:\n"
        "    print(sum(run(executor, abs, [(-1,), (2,)])), {pid == os.getpid() for pid, _ in run(executor, own, [(1,), (2,)])})\n"
    )
    done = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines() == ["begun", "3 {True}"]
    assert done.stderr.count("\n") == 1 and "in one process" in done.stderr
