"""Whatever a dataset, its markers and its trials are called, every command prints, draws and writes what it found."""

import json
from dataclasses import replace

import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.diagnose import command as diagnose
from hsr_pin.cli.fit import command as fit
from hsr_pin.cli.import_ import command as import_
from hsr_pin.cli.replay import command as replay
from hsr_pin.cli.sim import command as sim
from hsr_pin.recordings.write import write_dataset

#: Markup of matplotlib, rich, HTML, format strings and templates; signs that few fonts have; what legends leave out.
ODD = ("$x$", r"$\frac{", "[/]", "[bold red]x", ":smile:", "<b>&amp;", "{0} %s ${viewer}", "_hidden", "漢字", "a/../b", "x" * 120)


def named(dataset, name, trial):
    """The dataset under another name, each trial and marker too."""
    markers = tuple(replace(marker, name=f"{name}{number}") for number, marker in enumerate(dataset.markers))
    return replace(
        dataset,
        name=name,
        trials=tuple(
            replace(each, name=f"{trial}{number}", trajectory=replace(each.trajectory, markers=markers))
            for number, each in enumerate(dataset.trials)
        ),
    )


@pytest.fixture
def folder(heavy_tip, tmp_path):
    """``folder(name)``: two trials and all their markers by that name."""

    def make(name):
        short = replace(heavy_tip, trials=heavy_tip.trials[:2])
        write_dataset(named(short, name, name.replace("/", "").replace("\\", "") or "x"), tmp_path / "d")
        return str(tmp_path / "d")

    return make


@pytest.mark.parametrize("name", ODD)
def test_tables_plots_and_pages_take_any_name(folder, tmp_path, monkeypatch, capsys, name):
    monkeypatch.setenv("COLUMNS", "400")  # room for every cell
    data, picture, page = folder(name), str(tmp_path / "p.png"), str(tmp_path / "p.html")
    assert run(replay, [data, "--plot", picture, "--html", page]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert name in out and f"{name}1" in out
    assert out.splitlines()[-2:] == [f"wrote {picture}", f"wrote {page}"]
    assert run(sim, ["--against", data]) == 0
    assert name in capsys.readouterr().out
    assert run(fit, [data, "--plot", str(tmp_path / "f.svg"), "--free", "keq", "--links", "2"]) == 0
    out, err = capsys.readouterr()
    assert err == "" and out.startswith(f"{name}: 2 trials fitted")


@pytest.mark.parametrize("name", ["$x$", "[/]", "<b>&amp;", "漢字"])
def test_a_diagnosis_takes_any_name(folder, tmp_path, capsys, name):
    report = tmp_path / "r.html"
    arguments = ["--effects", "tip_mass", "--max-effects", "0", "--links", "2", "--jobs", "1", "--html", str(report)]
    assert run(diagnose, [folder(name), *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == "" and out.startswith(f"{name}: ")
    assert out.splitlines()[-1] == f"wrote {report}"
    text = report.read_text(encoding="utf-8")
    assert name.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;") in text


@pytest.mark.parametrize("option", ["--html", "--plot"])
def test_the_verdict_is_printed_before_anything_that_may_fail_is_written(folder, tmp_path, monkeypatch, capsys, option):
    def fail(*_, **__):
        raise ZeroDivisionError("a fault of ours")

    monkeypatch.setattr("hsr_pin.replay.page.write_page", fail)
    monkeypatch.setattr("hsr_pin.replay.plots.comparison_figure", fail)
    monkeypatch.setattr("hsr_pin.diagnosis.report.write_report", fail)
    monkeypatch.setattr("hsr_pin.identification.figure.fit_figure", fail)
    data, file = folder("arm"), str(tmp_path / "f.png")
    few = ["--links", "2"]
    cases = [(replay, [data, *few, option, file], "arm: 2 links")]
    if option == "--html":
        cases.append(
            (diagnose, [data, *few, "--effects", "tip_mass", "--max-effects", "0", "--jobs", "1", option, file], "arm: ")
        )
    else:
        cases.append((fit, [data, *few, "--free", "keq", option, file], "arm: 2 trials fitted"))
    for command, arguments, said in cases:
        with pytest.raises(ZeroDivisionError):
            run(command, arguments)
        assert capsys.readouterr().out.startswith(said)
    with pytest.raises(ZeroDivisionError):
        run(replay, [data, *few, option, file, "--json"])
    assert json.loads(capsys.readouterr().out)["written"] == []


def test_escape_codes_in_a_capture_are_shown_not_sent(tmp_path, capsys):
    lines = ["Trajectories", "100", ",,\x1b[31mred,,,\x9b5mtip\x07,,", "Frame,Sub Frame" + ",X,Y,Z" * 2, "," + ",mm" * 6]
    lines += [f"{frame},0,0,0,0,0,0,{-frame}" for frame in range(1, 20)]
    path = tmp_path / "take\x1b[2J.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    assert run(import_, [str(path), "--list"]) == 0
    out, _ = capsys.readouterr()
    assert all(line.isprintable() for line in out.splitlines())
    assert "?[31mred" in out and "?5mtip?" in out and r"take\x1b[2J.csv" in out


def test_escape_codes_in_arguments_and_paths_are_shown_not_sent(tmp_path, capsys):
    for arguments in (["\x1b[31mgone"], ["gone", "--links", "\x1b[31m4"], ["g\udcffne"], ["x" * 5000]):
        assert run(replay, arguments) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1 and err[:-1].isprintable()
        assert len(err) < 400


def test_a_marker_that_was_seen_in_no_fitted_trial_is_a_dash(heavy_tip, tmp_path, capsys):
    trials = []
    for number, trial in enumerate(heavy_tip.trials):
        positions = trial.trajectory.positions.copy()
        positions[:, -1] = positions[:, -1] if number == 3 else float("nan")
        trials.append(replace(trial, trajectory=replace(trial.trajectory, positions=positions)))
    write_dataset(replace(heavy_tip, trials=tuple(trials)), tmp_path / "d")
    arguments = [str(tmp_path / "d"), "--links", "2", "--train", "trial_01,trial_02", "--test", "trial_03"]
    assert run(fit, arguments) == 0
    out, err = capsys.readouterr()
    assert err == "" and "nan" not in out
    (line,) = (line for line in out.splitlines() if line.strip().startswith("fitted trials, tip"))
    assert line.split()[3:] == ["-"] * 4


def test_a_marker_that_one_trial_never_shows_is_drawn_and_compared_without_it(heavy_tip, tmp_path, capsys):
    first, *others = heavy_tip.trials[:3]
    positions = first.trajectory.positions.copy()
    positions[:, -1] = float("nan")
    write_dataset(replace(heavy_tip, trials=(first, *others)), tmp_path / "old")
    hidden = replace(first, trajectory=replace(first.trajectory, positions=positions))
    write_dataset(replace(heavy_tip, trials=(hidden, *others)), tmp_path / "new")
    few = ["--links", "2"]
    assert run(fit, [str(tmp_path / "new"), *few, "--free", "keq", "--plot", str(tmp_path / "f.svg")]) == 0
    since = ["--since", str(tmp_path / "old"), *few, "--effects", "tip_mass", "--jobs", "1"]
    assert run(diagnose, [str(tmp_path / "new"), *since]) == 0
    assert " nan" not in capsys.readouterr().out
