"""Options, table of errors and picture of the examples."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.figure import Figure

from hsr_pin.control.reference import Reference
from hsr_pin.replay.plots import COLOURS, DASHES, save
from hsr_pin.trajectory import Array


@dataclass
class Run:
    """Recorded run of a controller.

    Attributes:
        tip: tip position (3,) at every sample [m].
        torque: torque of every step [N m].
        unknown_torque: estimate of an unknown torque at every step [N m]; empty without an observer.
    """

    tip: list[Array] = field(default_factory=list)
    torque: list[float] = field(default_factory=list)
    unknown_torque: list[float] = field(default_factory=list)

    def errors(self, reference: Reference) -> Array:
        """Return the distance of the tip from the reference (T,) [mm]."""
        return 1e3 * np.linalg.norm(np.array(self.tip) - reference.tip, axis=1)


def options(arguments: Sequence[str] | None, text: str | None) -> argparse.Namespace:
    """Return the options ``--plot FILE`` and ``--quick`` of an example with the docstring ``text``."""
    parser = argparse.ArgumentParser(description=(text or "").partition("\n")[0])
    parser.add_argument("--plot", metavar="FILE", help="write a picture, as .png, .svg or .pdf")
    parser.add_argument("--quick", action="store_true", help="follow a short reference")
    return parser.parse_args(arguments)


def report(title: str, reference: Reference, runs: dict[str, Run], plot: str | None) -> dict[str, float]:
    """Print and return the RMS tip error of each run [mm], and draw the runs into the file ``plot``, if any."""
    rms = {name: float(np.sqrt(np.mean(run.errors(reference) ** 2))) for name, run in runs.items()}
    print(title)
    width = max(12, *map(len, rms))
    for name, value in rms.items():
        print(f"  {name:<{width}} tip error {value:6.2f} mm RMS, {runs[name].errors(reference).max():6.2f} mm at most")
    if plot:
        save(_figure(title, reference, runs), plot)
        print(f"  picture in {plot}")
    return rms


def _figure(title: str, reference: Reference, runs: dict[str, Run]) -> Figure:
    estimated = any(run.unknown_torque for run in runs.values())
    figure = Figure(figsize=(7.2, 8.0 if estimated else 6.4), layout="constrained")
    figure.suptitle(title, fontsize=11)
    tip, error, torque, *more = figure.subplots(3 + estimated, 1, sharex=True, height_ratios=(1.3, 1, 1, 1)[: 3 + estimated])
    tip.plot(reference.time, 1e3 * reference.tip[:, 0], color="#BBBBBB", linewidth=4.0, label="reference", zorder=1)
    styles = zip(COLOURS[len(runs) - 1 :: -1], DASHES[len(runs) - 1 :: -1], strict=True)
    for (colour, dashes), (name, run) in zip(styles, runs.items(), strict=True):
        tip.plot(reference.time, 1e3 * np.array(run.tip)[:, 0], color=colour, ls=dashes, label=name)
        error.plot(reference.time, run.errors(reference), color=colour, ls=dashes, label=name)
        if run.unknown_torque:
            more[0].plot(reference.time[:-1], run.unknown_torque, color=colour)
            more[0].set_ylabel("unknown torque,\nestimated [N m]")
        torque.step(reference.time[:-1], run.torque, where="post", color=colour, ls=dashes, linewidth=1.0, label=name)
    tip.set_ylabel("tip x [mm]")
    error.set_ylabel("tip error [mm]")
    error.set_ylim(bottom=0)
    torque.set_ylabel("torque [N m]")
    (more or [torque])[-1].set_xlabel("time [s]")
    figure.legend(*tip.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    for axes in (tip, error, torque, *more):
        axes.grid(color="#DDDDDD", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    figure.align_ylabels()
    return figure
