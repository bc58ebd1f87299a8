"""Times as cameras and loggers print them go through every command, and give the numbers of the exact ones."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.cli import fit, replay, sim
from hsr_pin.cli.command import run
from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.identification.evaluation import simulate_run
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.recordings.clean import clean
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Trajectory, Trial

JITTER = np.random.default_rng(3)

#: How the times of a recording are printed: their rate [Hz], and what becomes of exact times [s].
PRINTED = {
    "120 Hz to a microsecond": (120, lambda t: np.round(t, 6)),
    "120 Hz to a millisecond": (120, lambda t: np.round(t, 3)),
    "100 Hz in Unix time": (100, lambda t: 1.7e9 + t),
    "120 Hz in Unix time to a microsecond": (120, lambda t: np.round(1.7e9 + t, 6)),
    "100 Hz with a jitter of 0.5 %": (100, lambda t: t + JITTER.uniform(-5e-5, 5e-5, len(t))),
    "100 Hz with a jitter of 15 %": (100, lambda t: t + JITTER.uniform(-1.5e-3, 1.5e-3, len(t))),
}


def exact(rate):
    trials = []
    for number, torque in enumerate((0.5, -0.9), 1):
        motion = simulate(step_scenario(ArmSpecification(), torque, duration=1.0, step=1 / rate)).trajectory
        recording = Trajectory(motion.time, motion.markers, motion.positions, torque=motion.torque)
        trials.append(Trial(f"trial_{number:02d}", recording, keq=1.3, damping=0.05))
    return Dataset("known", 0.24, 0.15, 0.04, "hanging", tuple(trials))


@pytest.fixture(scope="module", params=PRINTED, ids=list(PRINTED))
def folders(request, tmp_path_factory):
    """A dataset with exact times, and the same as it would have been printed."""
    rate, printed = PRINTED[request.param]
    dataset, made = exact(rate), tmp_path_factory.mktemp("printed")
    write_dataset(dataset, made / "exact")
    write_dataset(dataset, made / "printed")
    for trial in dataset.trials:
        path = made / "printed" / f"{trial.name}.csv"
        header, *rows = path.read_text(encoding="utf-8").splitlines()
        times = printed(trial.trajectory.time)
        assert np.ptp(np.diff(times)) > 1e-6 / rate  # nothing that a scenario would take
        rows = [",".join([repr(float(t)), *row.split(",")[1:]]) for t, row in zip(times, rows, strict=True)]
        path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return made / "exact", made / "printed"


def document(command, capsys, *arguments):
    assert run(command, [str(argument) for argument in arguments]) == 0
    return json.loads(capsys.readouterr().out)


def test_sim_and_replay_compare_it(folders, capsys):
    for asked in ((replay.command,), (sim.command, "--against")):
        wanted, found = (document(*asked[:1], capsys, *asked[1:], folder, "--json")["errors"] for folder in folders)
        assert [one["rms"] for one in found] == pytest.approx([one["rms"] for one in wanted], rel=0.02)


def test_fit_finds_the_same_stiffness(folders, capsys):
    asked = ("--links", "4", "--placement", "base", "--free", "keq", "--json", "-")
    wanted, found = (document(fit.command, capsys, folder, *asked)["parameters"]["keq_scale"]["value"] for folder in folders)
    assert found == pytest.approx(wanted, rel=5e-3)


def test_identification_and_diagnosis_simulate_it_at_its_samples(folders):
    experiment = prepare(read_dataset(folders[1]))
    for one in experiment.runs:
        answer = simulate_run(experiment, one, Hypothesis(free=()), np.empty((1, 0)))
        assert len(answer.positions) == len(one.time)


@pytest.mark.long
def test_diagnosis_comes_to_a_verdict_on_it(folders):
    assert diagnose(read_dataset(folders[1])).verdict.sentence


def test_a_dataset_made_in_memory_is_put_on_even_times_too(folders):
    dataset = exact(100)
    uneven = [
        replace(trial, trajectory=replace(trial.trajectory, time=1.7e9 + trial.trajectory.time), t_start=1.7e9 + 0.2)
        for trial in dataset.trials
    ]
    for trial in clean(replace(dataset, trials=tuple(uneven))).trials:
        assert np.ptp(np.diff(trial.trajectory.time)) < 1e-9
        assert trial.t_start == pytest.approx(0.2, abs=1e-6)


def test_what_was_done_is_said_where_it_is_more_than_a_last_digit(folders, request):
    notes = [note for trial in read_dataset(folders[1]).trials for note in trial.trajectory.notes]
    name = request.node.callspec.params["folders"]
    assert any("Unix" not in name or "counted from the first sample" in note for note in notes) or "microsecond" in name
    assert any("jitter" in note or "uneven" in note for note in notes) == ("jitter" in name)
