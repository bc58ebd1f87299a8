"""Rest poses: how they scatter where the arm should stand alike, and whether they lie towards the side that it came from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from hsr_pin.diagnosis.commands import Plateau, plateaus
from hsr_pin.diagnosis.fingerprint.bending import bending
from hsr_pin.diagnosis.fingerprint.prints import Print, counted, said
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of, mean_of
from hsr_pin.identification.prepared import Run
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Share of a plateau, at its end, over which a place of rest is averaged; the part before tells whether the arm still moves.
_END = 0.1
#: It rests if it moves by less than this many noises, or less than this share of the run's motion, from the one to the other.
_STILL, _SHARE = 2.0, 0.02
#: ... and if it rings there by less than so many noises, or by this share of its length.
_RINGS = 0.001
#: Rests scatter if they do by more than so many times what noise makes of a mean, and by this share of the arm's length.
_SURE, _WORTH = 3.0, 0.002
#: Rests are scattered by the motion if they are by so many times what they were before it.
_GROWS = 2.0
#: They go on if they lessened their distance by more than this share in the last half of the last command.
_FADES = 0.2
#: Fewer rests under the same command do not tell how they scatter.
_FEWEST = 3


class Rest(NamedTuple):
    """Where the farthest marker stands at one end of a trial.

    Attributes:
        trial: its name.
        group: rests of one group should be alike: declared stiffness, payload, command, and whether it is a trial's first rest.
        across: [m] in the plane, across the straight arm, towards positive bending.
        along, sideways: [m] along the straight arm; out of the plane.
        early: [m] where it was, across, half-way through the plateau.
        side: 1 or -1: the side that it came from; 0: not known.
    """

    trial: str
    group: tuple[float, float, float, bool]
    across: float
    along: float
    sideways: float
    early: float
    side: int


@dataclass(frozen=True, eq=False)
class Rests(Print):
    """Scatter and direction of rest poses.

    Attributes:
        rests: those that can be compared.
        scatter: [m] standard deviation in the plane, within a group, of those from the same side.
        first_scatter: [m] the same of the rests that trials begin with; NaN without any.
        sideways: [m] as ``scatter``, out of the plane.
        towards: [m] by which a rest lies towards the side that it came from: of commanded trials, from their own first rest under
            the same command; of releases, from the middle between both sides, or from the straight arm where there is one only.
        faded: [m] by how much less that is than half-way through the last command; nothing of this for releases.
        one_sided: all of a group come from the same side, so that an arm that is bent at rest looks the same.
        resolution: [m] scatter that noise alone makes.
        length: of the arm [m].
    """

    rests: tuple[Rest, ...]
    scatter: float
    first_scatter: float
    sideways: float
    towards: Estimate
    faded: Estimate
    one_sided: bool
    resolution: float
    length: float
    name: ClassVar[str] = "rests"
    title: ClassVar[str] = "Where the arm comes to rest"

    @property
    def scattered(self) -> bool:
        """Whether rests differ by more than noise, and by enough to matter."""
        largest = max(self.scatter, float(np.nan_to_num(self.first_scatter)), self.sideways)
        return largest > max(_SURE * self.resolution, _WORTH * self.length)

    @property
    def directed(self) -> bool:
        """Whether they lie towards the side that the arm came from."""
        return self.towards.low > 0 and self.towards.value > _WORTH * self.length

    @property
    def fades(self) -> bool:
        """Whether they go on to where they should be."""
        return self.directed and self.faded.low > 0 and self.faded.value > _FADES * (self.towards.value + self.faded.value)

    @property
    def kinds(self) -> tuple[str, ...]:
        kinds: tuple[str, ...] = ()
        if self.directed:
            kinds = ("creep",) if self.fades else ("friction", "mass_gravity") if self.one_sided else ("friction",)
        if not self.scattered or (self.fades and not self.first_scatter > self.scatter / _GROWS):
            return kinds  # rests that are not reached yet scatter by that
        sticks = not self.first_scatter > self.scatter / _GROWS  # what was there before the arm moved is none of its friction
        return (*dict.fromkeys((*("friction",) * sticks, *kinds)), "measurement")

    @property
    def sentence(self) -> str:
        text = f"{counted(len(self.rests), 'rest pose')} that should be alike"
        if not self.scattered and not self.directed:
            plane, out = said(1e3 * self.scatter), said(1e3 * self.sideways)
            return f"{text} scatter by {plane} mm in the plane and {out} mm out of it: the arm comes to rest where it should."
        parts, points = [], []
        if self.directed:
            parts.append(
                f"lie {said(1e3 * self.towards.value)} mm ({said(1e3 * self.towards.low)} to {said(1e3 * self.towards.high)} mm) "
                "towards the side that the arm came from"
            )
            points.append(
                "friction or hysteresis, or to an arm that is bent at rest (all trials come from one side)"
                if self.one_sided
                else "creep that has not ended (it lessens as they wait)"
                if self.fades
                else "friction or hysteresis"
            )
        if self.scattered:
            before = f" ({said(1e3 * self.first_scatter)} mm before the arm is moved)" if np.isfinite(self.first_scatter) else ""
            parts.append(
                f"scatter by {said(1e3 * self.scatter)} mm in the plane{before} and {said(1e3 * self.sideways)} mm out of it"
            )
            if "measurement" in self.kinds:
                points.append(
                    "a mount or markers that shift between trials"
                    if self.first_scatter > self.scatter / _GROWS
                    else "an arm that sticks where it happens to stop, or that shifts between trials"
                )
        return f"{text} {' and '.join(parts)}: this points to {', and to '.join(points)}."

    def numbers(self) -> dict[str, Any]:
        return {
            "scatter_m": self.scatter,
            "first_scatter_m": self.first_scatter,
            "sideways_m": self.sideways,
            "towards_m": self.towards,
            "faded_m": self.faded,
            "one_sided": self.one_sided,
            "resolution_m": self.resolution,
            "rests": [{**rest._asdict(), "group": list(rest.group)} for rest in self.rests],
        }

    def draw(self, axes: Axes) -> None:
        """Places of rest, in the plane and out of it, each from the mean of its group."""
        origins = _origins(self.rests, self.one_sided)
        groups = _grouped(self.rests)
        middle = {members[0].group: float(np.mean([rest.sideways for rest in members])) for members in groups}
        for side, marker, role, label in (
            (1, ">", "model", "came from the + side"),
            (-1, "<", "declared", "came from the \u2212 side"),
            (0, "o", "measured", "before the arm is moved"),
        ):
            places = [
                (rest.across - origin, rest.sideways - middle[rest.group])
                for rest, origin in zip(self.rests, origins, strict=True)
                if rest.side == side
            ]
            if places:
                axes.plot(
                    *(1e3 * np.transpose(places)), marker, ms=5, mew=0, alpha=0.8, color=ROLES[role], ls="none", label=label
                )
        least = 1e3 * 0.005 * self.length
        axes.plot([-least, least], [-least, least], ls="none")  # so that noise does not look large
        axes.axhline(0, color=ROLES["faint"], lw=0.6)
        axes.axvline(0, color=ROLES["faint"], lw=0.6)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.25)
        known = any(rest.group[3] for rest in self.rests)
        origin = "the straight arm" if self.one_sided else "each trial's first rest" if known else "the middle of those alike"
        axes.set(xlabel=f"in the plane, from {origin} [mm]", ylabel="out of the plane [mm]")
        axes.grid()
        axes.legend(loc="upper left")


def rests(experiment: Experiment) -> Rests | None:
    """Scatter and direction of rest poses; None where fewer than three trials rest under the same command."""
    found = [rest for run in experiment.runs for rest in _rests(run, experiment)]
    groups = [members for members in _grouped(found) if len(members) >= _FEWEST]
    if not groups:
        return None
    kept = tuple(rest for members in groups for rest in members)
    sides = [{rest.side for rest in members if rest.side} for members in groups]
    one_sided = not any(rest.group[3] for rest in kept) and all(len(each) < 2 for each in sides)
    sided = [
        (rest.trial, rest.side * (rest.across - origin), rest.side * (rest.early - rest.across))
        for rest, origin in zip(kept, _origins(kept, one_sided), strict=True)
        if rest.side and np.isfinite(origin)
    ]
    towards = faded = Estimate(np.nan, -np.inf, np.inf)
    if sided:
        trials, offsets, lessened = zip(*sided, strict=True)
        towards = coefficients_of(np.ones((len(sided), 1)), np.array(offsets), trials)[0]
        if any(rest.group[3] for rest in kept):
            faded = mean_of(lessened)
    first = [members for members in groups if members[0].group[3]]
    last = [members for members in groups if not members[0].group[3]] or first
    fewest = min(len(run.time) for run in experiment.runs)
    resolution = 1.25 * float(np.max(experiment.noise)) / np.sqrt(max(3.0, _END * fewest / 4))
    return Rests(
        rests=kept,
        scatter=_within(last, "across"),
        first_scatter=_within(first, "across") if first else float("nan"),
        sideways=_within(groups, "sideways"),
        towards=towards,
        faded=faded,
        one_sided=one_sided,
        resolution=resolution,
        length=experiment.dataset.length,
    )


def _rests(run: Run, experiment: Experiment) -> list[Rest]:
    """The first rest of a run that starts settled, and its last."""
    motion = bending(run, experiment)
    held = plateaus(run)
    if not held:
        return []
    ends = [(held[-1], False)] if len(held) > 1 or run.start_pose is not None else []
    if run.start_pose is None:
        ends.append((held[0], True))
    found = []
    for plateau, first in ends:
        window = run.measured[plateau.first : plateau.last + 1, motion.marker]
        count = max(5, round(_END * len(window)))
        late, before = (part[np.isfinite(part[:, 0])] for part in (window[-count:], window[-2 * count : -count]))
        if not len(late):
            continue
        place = np.median(late, axis=0)
        if motion.ringing(plateau) > max(_STILL * motion.noise, 2 * _RINGS):  # a chord turns by half the bending
            continue
        # A trial may begin at its first command: then it is taken to have rested.
        if not first and len(before) and _moved(place, before, run, motion.marker, float(experiment.noise[motion.marker])):
            continue
        middle = window[int(0.4 * len(window)) : int(0.6 * len(window)) + 1]
        early = np.median(middle[np.isfinite(middle[:, 0])], axis=0) if np.isfinite(middle[:, 0]).any() else place
        across, along = motion.plane(place)
        came = 0 if first else _side(plateau.first, motion.settled(plateau), motion.start, held)
        group = (run.trial.keq, run.trial.tip_mass, round(plateau.torque, 6), first)
        found.append(Rest(run.trial.name, group, across, along, float(place[1]), motion.plane(early)[0], came))
    return found


def _moved(place: Array, before: Array, run: Run, marker: int, noise: float) -> bool:
    shown = run.measured[np.isfinite(run.measured[:, marker, 0]), marker]
    span = float(np.max(np.percentile(shown, 98, axis=0) - np.percentile(shown, 2, axis=0)))
    moved = float(np.linalg.norm(place - np.median(before, axis=0)))
    return moved > max(_STILL * noise, _SHARE * span)


def _side(first: int, rest: float, start: float, held: tuple[Plateau, ...]) -> int:
    if first == 0:  # released
        return int(np.sign(start - rest)) if np.isfinite(rest) else 0  # unless nothing was seen where it came to rest
    if len(held) < 2:  # it moved under one command from the start: nobody knows from where
        return 0
    return int(np.sign(held[-2].torque - held[-1].torque))


def _grouped(found: Any) -> list[list[Rest]]:
    groups: dict[tuple[float, float, float, bool], list[Rest]] = {}
    for rest in found:
        groups.setdefault(rest.group, []).append(rest)
    return list(groups.values())


def _origins(found: tuple[Rest, ...], one_sided: bool) -> list[float]:
    """For each rest where it would be whatever side the arm came from [m]; NaN where that is not known.

    The trial's first rest under the same command, if trials begin with one (the mean of first rests, for themselves); for
    releases the middle between those from either side, or the straight arm if there is one side only.
    """
    began = {(rest.trial, rest.group[:3]): rest.across for rest in found if rest.group[3]}
    origins = []
    for rest in found:
        alike = [other for other in found if other.group == rest.group]
        if rest.group[3]:
            origins.append(float(np.mean([other.across for other in alike])))
        elif began:
            origins.append(began.get((rest.trial, rest.group[:3]), float("nan")))
        elif one_sided:
            origins.append(0.0)
        else:
            sides = {other.side for other in alike}
            origins.append(float(np.mean([np.mean([o.across for o in alike if o.side == side]) for side in sides])))
    return origins


def _within(groups: list[list[Rest]], name: str) -> float:
    """Standard deviation within groups, those from either side apart."""
    total, freedom = 0.0, 0
    for members in groups:
        for side in {rest.side for rest in members}:
            values = np.array([getattr(rest, name) for rest in members if rest.side == side])
            total += float(((values - values.mean()) ** 2).sum())
            freedom += len(values) - 1
    return float(np.sqrt(total / freedom)) if freedom else 0.0
