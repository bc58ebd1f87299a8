"""Print, as Markdown, how well fitted arms predict held-out real recordings.

Usage: scripts/real_data.py [folder of recordings]. Default: ../shared/recordings next to the repository. Takes about a minute.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hsr_pin.identification.identify import Identification, identify
from hsr_pin.inference.residuals import rms
from hsr_pin.recordings.read import read_dataset
from hsr_pin.trajectory import Array

ROOT = Path(__file__).resolve().parent.parent
HEADER = (
    "| dataset | fitted to | predicted | parameters | tip RMS fitted | tip RMS predicted | as declared | "
    "all markers, predicted | scatter of rests taken out |\n" + "|---" * 9 + "|\n"
)
#: Number of samples at the end of a release in which the arm is at rest.
REST = 30


@dataclass(frozen=True)
class Case:
    """One prediction.

    Attributes:
        dataset: name of the folder.
        train: patterns of the trials that are fitted; all others are predicted.
        fitted, predicted: description of the fitted and of the predicted trials.
        free: names of the fitted parameters.
        delay: time after the declared start from which samples are used [s].
    """

    dataset: str
    train: tuple[str, ...]
    fitted: str
    predicted: str
    free: tuple[str, ...] = ("keq", "damping")
    delay: float = 0.0


_BEAM = ("real-beam", ("trial_0[12]",), "unloaded releases (2)", "releases with 52 g (2)")
_TRUNK = ("real-trunk", ("trial_0?", "trial_1[012]"), "releases with 200 g (12)", "releases with 300 g (20)")
CASES = (
    Case(*_BEAM),
    Case(*_BEAM, delay=0.05),
    Case(*_TRUNK),
    Case(*_TRUNK, delay=0.1),
    Case(*_TRUNK, free=("keq", "damping", "hysteresis"), delay=0.1),
)


def found_in(folder: Path, case: Case) -> Identification:
    """Return the identification of one case."""
    return identify(read_dataset(folder / case.dataset), free=case.free, train=case.train, delay=case.delay)


def aligned(missed: Sequence[Array]) -> list[Array]:
    """Return the errors of each trial, (T, M, A) [m], minus the deviation of its rest error from the mean over trials."""
    rests = [np.nanmean(each[-REST:], axis=0) for each in missed]
    return [each - (rest - np.mean(rests, axis=0)) for each, rest in zip(missed, rests, strict=True)]


def row(case: Case, found: Identification) -> str:
    """Return one row of the table."""
    length = found.experiment.dataset.length
    values = ", ".join(f"{name} {value:.3g}" for name, value in found.fit.named.items())
    start = f", from {case.delay:g} s on" if case.delay else ""
    tip = [found.tip_rms(missed) for missed in (found.after, found.heldout, found.heldout_before)]
    whole = [rms(missed) for missed in (found.heldout, aligned(found.heldout))]
    cells = [f"{1e3 * distance:.1f} mm ({100 * distance / length:.1f} % of L)" for distance in (*tip, *whole)]
    return f"| {case.dataset} | {case.fitted}{start} | {case.predicted} | {values} | {' | '.join(cells)} |\n"


def limits(found: Identification) -> str:
    """Return the limits of a planar model with one rest pose: motion out of the plane, and scatter of the rest pose."""
    runs = [run.measured[:, found.tip] for run in found.heldout_experiment.runs]
    out = 1e3 * np.sqrt(np.nanmean(np.concatenate([tip[:, 1] ** 2 for tip in runs])))
    rest = 1e3 * np.array([np.nanmean(tip[-30:], axis=0) for tip in runs])
    return (
        f"{found.experiment.dataset.name}, predicted trials: out of plane {out:.1f} mm RMS; the tip comes to rest at "
        f"x = {rest[:, 0].mean():.1f} ± {rest[:, 0].std():.1f} mm, y = {rest[:, 1].mean():.1f} ± {rest[:, 1].std():.1f} mm "
        "(mean ± standard deviation over trials).\n"
    )


def main() -> None:
    """Print the table and the limits."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT.parent / "shared" / "recordings"
    print(HEADER, end="")
    last = {}
    for case in CASES:
        found = found_in(folder, case)
        print(row(case, found), end="", flush=True)
        last[case.dataset] = found
    for found in last.values():
        print("\n" + limits(found), end="")


if __name__ == "__main__":
    main()
