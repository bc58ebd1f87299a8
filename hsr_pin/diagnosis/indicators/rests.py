"""Equilibrium poses: their scatter where they should be equal, and whether they depend on the side of approach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from hsr_pin.diagnosis.commands import Plateau, plateaus
from hsr_pin.diagnosis.indicators.bending import bending
from hsr_pin.diagnosis.indicators.indicator import Indicator, counted, rounded
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, mean_by_trial, mean_of
from hsr_pin.identification.prepared import Run
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Share of a plateau, at its end, over which the position is averaged; the part before it shows whether the arm still moves.
_END = 0.1
#: Largest motion of an arm at rest between these parts: in standard deviations of noise, or as a share of the run's motion ...
_STILL, _SHARE = 2.0, 0.02
#: ... and largest oscillation, as a share of the arm's length.
_RINGS = 0.001
#: Least significant scatter: as a multiple of the noise of a mean, and as a share of the arm's length.
_SURE, _WORTH = 3.0, 0.002
#: The motion causes the scatter if it exceeds that of the initial equilibria by this factor.
_GROWS = 2.0
#: Least relative decrease of the displacement in the last half of the last plateau that is significant.
_FADES = 0.2
#: Least number of equilibria under the same command.
_FEWEST = 3


class Rest(NamedTuple):
    """Equilibrium position of the outermost marker at one end of a trial.

    Attributes:
        trial: name of the trial.
        group: declared stiffness, payload, command, and whether it is the initial equilibrium; equilibria of one group should be
            equal.
        across: position in the plane across the straight arm, towards positive bending [m].
        along, sideways: positions along the straight arm and out of the plane [m].
        early: position across at the middle of the plateau [m].
        side: side of approach: 1, -1, or 0 if it is unknown.
    """

    trial: str
    group: tuple[float, float, float, bool]
    across: float
    along: float
    sideways: float
    early: float
    side: int


@dataclass(frozen=True, eq=False)
class Rests(Indicator):
    """Scatter of equilibrium poses, and their dependence on the side of approach.

    Attributes:
        rests: the equilibria that can be compared.
        scatter: standard deviation in the plane within groups of the same side [m].
        first_scatter: the same for initial equilibria [m]; NaN without any.
        sideways: as ``scatter``, out of the plane [m].
        towards: offset of an equilibrium towards the side of approach [m]: in commanded trials relative to the initial
            equilibrium under the same command; in releases relative to the middle between both sides, or to the straight arm if
            there is one side only.
        faded: decrease of this offset since the middle of the last plateau [m]; not determined for releases.
        one_sided: whether all equilibria of a group have the same side of approach, so that an arm with rest curvature looks the
            same.
        resolution: scatter from noise alone [m].
        length: length of the arm [m].
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
        """Whether the equilibria scatter by more than noise, and by a relevant amount."""
        largest = max(self.scatter, float(np.nan_to_num(self.first_scatter)), self.sideways)
        return largest > max(_SURE * self.resolution, _WORTH * self.length)

    @property
    def directed(self) -> bool:
        """Whether the equilibria are displaced towards the side of approach."""
        return self.towards.low > 0 and self.towards.value > _WORTH * self.length

    @property
    def fades(self) -> bool:
        """Whether the displacement decreases during the plateaus."""
        return self.directed and self.faded.low > 0 and self.faded.value > _FADES * (self.towards.value + self.faded.value)

    @property
    def kinds(self) -> tuple[str, ...]:
        kinds: tuple[str, ...] = ()
        if self.directed:
            kinds = ("creep",) if self.fades else ("friction", "mass_gravity") if self.one_sided else ("friction",)
        if not self.scattered or (self.fades and not self.first_scatter > self.scatter / _GROWS):
            return kinds  # equilibria that are not reached yet scatter too
        sticks = not self.first_scatter > self.scatter / _GROWS  # initial scatter is not caused by friction
        return (*dict.fromkeys((*("friction",) * sticks, *kinds)), "measurement")

    @property
    def sentence(self) -> str:
        text = f"{counted(len(self.rests), 'rest pose')} that should be equal"
        if not self.scattered and not self.directed:
            plane, out = rounded(1e3 * self.scatter), rounded(1e3 * self.sideways)
            return f"{text} scatter by {plane} mm in the plane and {out} mm out of it: the arm comes to rest where it should."
        parts, points = [], []
        if self.directed:
            parts.append(
                f"lie {rounded(1e3 * self.towards.value)} mm "
                f"({rounded(1e3 * self.towards.low)} to {rounded(1e3 * self.towards.high)} mm) "
                "towards the side from which the arm came"
            )
            points.append(
                "friction or hysteresis, or to an arm that is bent at rest (all trials come from one side)"
                if self.one_sided
                else "creep that has not ended (the offset decreases during the plateau)"
                if self.fades
                else "friction or hysteresis"
            )
        if self.scattered:
            before = (
                f" ({rounded(1e3 * self.first_scatter)} mm before the arm is moved)" if np.isfinite(self.first_scatter) else ""
            )
            parts.append(
                f"scatter by {rounded(1e3 * self.scatter)} mm in the plane{before} and "
                f"{rounded(1e3 * self.sideways)} mm out of it"
            )
            if "measurement" in self.kinds:
                points.append(
                    "a mount or markers that shift between trials"
                    if self.first_scatter > self.scatter / _GROWS
                    else "static friction that holds the arm where it stops, or to shifts between trials"
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
        """Draw the equilibrium positions in the plane and out of it, relative to their group."""
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
        axes.plot([-least, least], [-least, least], ls="none")  # least range of the axes
        axes.axhline(0, color=ROLES["faint"], lw=0.6)
        axes.axvline(0, color=ROLES["faint"], lw=0.6)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.25)
        known = any(rest.group[3] for rest in self.rests)
        origin = "the straight arm" if self.one_sided else "each trial's first rest" if known else "the mean of its group"
        axes.set(xlabel=f"in the plane, from {origin} [mm]", ylabel="out of the plane [mm]")
        axes.grid()
        axes.legend(loc="upper left")


def rests(experiment: Experiment) -> Rests | None:
    """Return scatter and direction of equilibrium poses; None if fewer than three trials share a command."""
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
    towards = faded = Estimate(np.nan)
    if sided:
        trials, offsets, lessened = zip(*sided, strict=True)
        towards = mean_by_trial(offsets, trials)
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
    """Return the initial equilibrium of a run that starts in equilibrium, and its last equilibrium."""
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
        if motion.ringing(plateau) > max(_STILL * motion.noise, 2 * _RINGS):  # the chord rotates by half the bending angle
            continue
        # A trial may begin at its first command; it is then assumed to start in equilibrium.
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
    shown = run.shown(marker)
    span = float(np.max(np.percentile(shown, 98, axis=0) - np.percentile(shown, 2, axis=0)))
    moved = float(np.linalg.norm(place - np.median(before, axis=0)))
    return moved > max(_STILL * noise, _SHARE * span)


def _side(first: int, rest: float, start: float, held: tuple[Plateau, ...]) -> int:
    if first == 0:  # released
        return int(np.sign(start - rest)) if np.isfinite(rest) else 0  # unknown if the marker is not visible in equilibrium
    if len(held) < 2:  # with a single command the side of approach is unknown
        return 0
    return int(np.sign(held[-2].torque - held[-1].torque))


def _grouped(found: Any) -> list[list[Rest]]:
    groups: dict[tuple[float, float, float, bool], list[Rest]] = {}
    for rest in found:
        groups.setdefault(rest.group, []).append(rest)
    return list(groups.values())


def _origins(found: tuple[Rest, ...], one_sided: bool) -> list[float]:
    """Return for each equilibrium its reference position independent of the side of approach [m]; NaN if it is unknown.

    The reference is the initial equilibrium of the trial under the same command, or the mean of initial equilibria for these
    themselves. For releases it is the middle between both sides, or the straight arm if there is one side only.
    """
    began = {(rest.trial, rest.group[:3]): rest.across for rest in found if rest.group[3]}
    origins = []
    for rest in found:
        group_members = [other for other in found if other.group == rest.group]
        if rest.group[3]:
            origins.append(float(np.mean([other.across for other in group_members])))
        elif began:
            origins.append(began.get((rest.trial, rest.group[:3]), float("nan")))
        elif one_sided:
            origins.append(0.0)
        else:
            sides = {other.side for other in group_members}
            origins.append(float(np.mean([np.mean([o.across for o in group_members if o.side == side]) for side in sides])))
    return origins


def _within(groups: list[list[Rest]], name: str) -> float:
    """Return the standard deviation within groups, with both sides of approach separate."""
    total, freedom = 0.0, 0
    for members in groups:
        for side in {rest.side for rest in members}:
            values = np.array([getattr(rest, name) for rest in members if rest.side == side])
            total += float(((values - values.mean()) ** 2).sum())
            freedom += len(values) - 1
    return float(np.sqrt(total / freedom)) if freedom else 0.0
