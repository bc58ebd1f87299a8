"""From what was fitted to what may be said of a change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from hsr_pin.diagnosis.change.chance import Chance
from hsr_pin.diagnosis.change.fitting import Fitted
from hsr_pin.diagnosis.change.frame import Frame
from hsr_pin.diagnosis.change.size import Size, left_out, sizes
from hsr_pin.diagnosis.change.swing import slack
from hsr_pin.diagnosis.change.words import listed, millimetres, told
from hsr_pin.trajectory import Array

#: A change is there if it explains at least so much (a difference of log-likelihoods, doubled), and this many times what the same
#: change would explain between OLD's own trials ...
SURE, TIMES = 60.0, 2.0
#: ... (and if it moves the markers by what is worth a word: `Pair.worth`).
#: A second change must take away this share of what the first does.
SECOND = 0.05
#: A change is not named where another of no certain size, without it, explains more by this share of what it does.
BETTER = 0.02
#: Another change explains as much if it lacks no more than this: neither model is exact. A share of what the best explains,
#: a share of what it leaves, a share of what it does not foretell of trials that it was not fitted to, and a number of
#: log-likelihoods besides; each further parameter costs so many.
TIED, OF_LEFT, UNFORETOLD, NEARLY, PARAMETER = 0.002, 1.0, 0.1, 15.0, 8.0
#: Nothing else has changed if no larger share than this of what OLD does not foretell is left ...
REST = 0.1
#: ... and a change that explains less than this is not named.
HALF = 0.5
#: What is left in NEW is no scatter of trials where its mean square is so many times that of the worst of OLD's; nor is what OLD
#: does not foretell of NEW where it is so many times as far as that.
FARTHER = 2.0


@dataclass(frozen=True)
class Difference:
    """How far NEW is from what OLD foretells, RMS distances [m].

    Attributes:
        before: where nothing is taken to have changed.
        after: with the change.
        scatter: that would be no surprise if nothing had changed.
        share: of the difference, in units of its scatter, that the change explains on trials that it was not fitted to.
    """

    before: float
    after: float
    scatter: float
    share: float


@dataclass(frozen=True)
class ChangeVerdict:
    """What the recordings say of a change.

    Attributes:
        status: "identified", "partly_identified", "ambiguous", "unexplained", "unchanged" or "insufficient".
        effects: names of what has certainly changed, sorted; plain numbers of the arm under their own names.
        alternatives: sets of names that these recordings cannot tell apart, the best first.
        sentence: the verdict as a person would say it.
        kinds: of physics that have certainly changed, sorted.
        changes: from what to what, of the best model of the change, then of the alternatives.
        difference: how far NEW is from OLD; None where that could not be told.
        limits: name -> the smallest change that would have been seen; plain numbers: relative.
    """

    status: str
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    sentence: str
    kinds: tuple[str, ...] = ()
    changes: tuple[Size, ...] = ()
    difference: Difference | None = None
    limits: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Found:
    """What a verdict rests on.

    Attributes:
        frame: what residuals are seen through.
        fits: (change, the frame it was fitted in), the best first; one for each set of names.
        chance: what OLD shows of ``looked`` by chance.
        looked: of which changes.
        was: 95 % intervals of the values of OLD's model, by name.
        spread: mean square of the residuals of each of OLD's trials.
    """

    frame: Frame
    fits: tuple[tuple[Fitted, Frame], ...]
    chance: Chance
    looked: tuple[tuple[str, ...], ...]
    was: Mapping[str, tuple[float, float]]
    spread: tuple[float, ...]

    @cached_property
    def sizes(self) -> dict[tuple[str, ...], tuple[Size, ...]]:
        """Of each of the fits, by its names."""
        return {f.suspect.names: sizes(frame, f, self.was, self.inflation(f)) for f, frame in self.fits}

    def moved(self, fitted: Fitted) -> int:
        """How many numbers are certainly others than they were."""
        return sum(size.moved for size in self.sizes[fitted.suspect.names])

    def sure(self, fitted: Fitted) -> bool:
        """Whether a change is there: it explains enough, moves the markers, and how large each of it is is known."""
        explains = self.gain(fitted) > self.needed(fitted) and fitted.rms >= self.frame.pair.worth
        return explains and {each.name for each in self.sizes[fitted.suspect.names] if each.clear} == set(fitted.suspect.names)

    def suffices(self, fitted: Fitted, wider: Fitted) -> bool:
        """Whether a special case of a change explains as good as all that it does, and its further numbers may be none."""
        more = self.moved(wider) > self.moved(fitted) and not self._alike(wider)
        return wider.suspect.contains(fitted.suspect) and not more and self.gain(fitted) > (1 - REST) * self.gain(wider)

    def _alike(self, fitted: Fitted) -> bool:
        """Whether the numbers that set a change apart from its special cases may all be the same."""
        steps = {size.parameter: size.step for size in self.sizes[fitted.suspect.names] if size.step is not None}
        apart = [[steps[name] for name in names if name in steps] for names in fitted.suspect.unlike]
        return bool(apart) and all(each and max(low for low, _ in each) <= min(high for _, high in each) for each in apart)

    def told(self, fitted: Fitted) -> tuple[Size, ...]:
        """What is said of a change: no damping that a swing at another rate may make."""
        found = self.sizes[fitted.suspect.names]
        own = [size for size in found if size.parameter == "damping_scale" and size.step is not None]
        if not own or len(fitted.suspect.names) < 2 or own[0].step is None:
            return found
        (low, high), (least, most) = own[0].step, slack(self.frame.pair, fitted)
        return tuple(size for size in found if size is not own[0]) if least < most and low <= most and high >= least else found

    @property
    def nothing(self) -> float:
        """Sum of the squared residuals where nothing has changed."""
        return float(self.frame.seen @ self.frame.seen)

    def gain(self, fitted: Fitted) -> float:
        """Of the squared residuals, what a change takes away."""
        return self.nothing - fitted.square

    def needed(self, fitted: Fitted) -> float:
        """Gain from which on a change is there."""
        own = [self.chance.gains[:, k].max() for k, names in enumerate(self.looked) if set(names) <= set(fitted.suspect.names)]
        return self.noisier(fitted) * max(SURE, TIMES * float(max(own, default=self.chance.largest)))

    def noisier(self, fitted: Fitted) -> float:
        """Mean square of what is left in NEW, at least 1: its noise may be more than OLD's."""
        return max(1.0, float(np.mean(fitted.residual[self.new] ** 2)))

    def inflation(self, fitted: Fitted) -> float:
        """Of the variance of its size, by what OLD shows."""
        own = [self.chance.inflation(k) for k, names in enumerate(self.looked) if set(names) <= set(fitted.suspect.names)]
        return max(own, default=1.0)

    @property
    def new(self) -> NDArray[np.bool_]:
        """(n,) which rows are of NEW."""
        return np.asarray(self.frame.run >= len(self.frame.pair.old.runs))

    def inexact(self, fitted: Fitted) -> float:
        """Squares left in NEW beyond what OLD's trials have, and as many others of them might have (one-sided, 95 %)."""
        left, own, count = fitted.residual[self.new] ** 2, np.array(self.spread), len(self.frame.pair.new.runs)
        doubt = float(stats.t.ppf(0.95, len(own) - 1) * own.std(ddof=1)) * sqrt(1 / len(own) + 1 / count)
        return max(0.0, float(left.sum()) - max(1.0, float(own.mean()) + doubt) * len(left))

    def left(self, residual: Array) -> float:
        """Squares left in NEW beyond what could be a bad trial of OLD; 0 where it could."""
        left = residual[self.new] ** 2
        return float(left.sum()) - len(left) * max(self.spread) if left.mean() > FARTHER * max(1.0, *self.spread) else 0.0

    def difference(self, fitted: Fitted) -> Difference:
        """How far a change brings NEW to what OLD foretells."""
        frame = next(frame for each, frame in self.fits if each is fitted)
        _, residual = left_out(frame, fitted)
        was, is_ = (float((each[self.new] ** 2).sum()) for each in (self.frame.seen, residual))
        share = (was - is_) / max(self.gain(fitted) + self.left(fitted.residual), was - is_, 1e-300)
        return Difference(self.frame.off(), frame.off(fitted.moved), self.frame.scatter, float(np.clip(share, 0.0, 1.0)))

    def nearer(self, fitted: Fitted) -> bool:
        """Whether a change brings NEW nearer in metres too, and does not only what counts most."""
        difference = self.difference(fitted)
        return difference.after < difference.before

    def cost(self, fitted: Fitted) -> float:
        """Squares left, more for every further parameter (G. Schwarz, Ann. Stat. 6, 1978)."""
        return fitted.square + PARAMETER * len(fitted.after)


def judge(found: Found) -> ChangeVerdict:
    """The verdict."""
    sure = [fitted for fitted, _ in found.fits if found.sure(fitted)]
    if not sure:
        return _nothing(found)
    sure = [fitted for fitted in sure if not needless(found, fitted, sure)]
    first = min(sure, key=found.cost)
    first = min((each for each in sure if found.suffices(each, first)), key=found.cost, default=first)
    first = undivided(found, first, sure)
    best, *others = ties = tied(found, first, [each for each in sure if found.gain(each) > HALF * found.gain(first)])
    if not found.nearer(best):
        return _nothing(found)
    left = found.left(best.residual)
    total = found.gain(best) + left
    other = better(found, best)
    difference = found.difference(best)
    own = found.told(best)
    changes = tuple(dict.fromkeys((*own, *(size for each in others for size in found.told(each)))))
    names = list(dict.fromkeys(tuple(sorted({size.name for size in found.told(each)})) for each in ties))
    common = tuple(sorted(set.intersection(*map(set, names))))
    kinds = tuple(sorted(set.intersection(*({each.suspect.kinds[s.name] for s in found.told(each)} for each in ties))))
    rest = "nothing else" if left <= REST * total else "something else as well, that no candidate explains"
    if beside := [size for size in found.sizes[best.suspect.names] if size not in own]:
        rest += f": {told(beside)} is no more than a swing at another rate may make"
    share = f"{100 * difference.share:.0f} % of the difference on held-out trials"

    def said(status: str, sentence: str, effects: tuple[str, ...], sets: Sequence[tuple[str, ...]] = ()) -> ChangeVerdict:
        known = () if status == "unexplained" else kinds
        return ChangeVerdict(status, effects, tuple(sets), sentence, known, changes, difference)

    if other is not None:
        what = f"the best that the catalogue offers ({listed(other.suspect.names)}) is of no certain size"
        return said("unexplained", f"Something has changed, by {millimetres(difference.before)}, and {what}.", ())
    if left > (1 - HALF) * total or difference.share < HALF:
        what = f"the best that the catalogue offers ({listed(names[0])}) explains {share}"
        return said("unexplained", f"Something has changed, by {millimetres(difference.before)}, and {what}.", ())
    if len(names) > 1:
        each = ", or ".join(" with ".join(one) for one in names)
        certain = f"{listed(common)} certainly; " if common else ""
        return said("ambiguous", f"These recordings cannot tell what has changed: {certain}{each} ({share}).", common, names)
    status = "identified" if left <= REST * total else "partly_identified"
    return said(status, f"{told(own)}; {rest} ({share}).", names[0])


def needless(found: Found, fitted: Fitted, sure: Sequence[Fitted]) -> bool:
    """Whether one change less explains as much but for what a second change is not told for."""
    fewer = [found.gain(other) for other in sure if set(other.suspect.names) < set(fitted.suspect.names)]
    return bool(fewer) and found.gain(fitted) - max(fewer) < SECOND * max(fewer)


def undivided(found: Found, best: Fitted, sure: Sequence[Fitted]) -> Fitted:
    """In place of two changes the one that is sure, where another beside it explains as much, though of no certain size."""
    own = set(best.suspect.names)
    as_good = [each for each, _ in found.fits if each is not best and found.gain(each) >= found.gain(best)]
    shared = [names for names in (set(each.suspect.names) & own for each in as_good) if 0 < len(names) < len(own)]
    alone = [each for each in sure if set(each.suspect.names) in shared and found.gain(each) > HALF * found.gain(best)]
    return min(alone, key=found.cost, default=best)


def better(found: Found, best: Fitted) -> Fitted | None:
    """A change of no certain size that has nothing to do with the best that is certain, and explains clearly more."""
    others = [each for each, _ in found.fits if not found.sure(each) and not set(best.suspect.names) <= set(each.suspect.names)]
    other = min(others, key=found.cost, default=None)
    if other is None or found.suffices(best, other):
        return None
    return other if found.cost(best) - found.cost(other) > BETTER * found.gain(best) else None


def tied(found: Found, best: Fitted, rivals: Sequence[Fitted]) -> list[Fitted]:
    """The changes that explain as much as the best, which come first; none that only has more numbers to bend."""
    explained = found.gain(best)
    unforetold = (1 - found.difference(best).share) * explained
    allowed = NEARLY * found.noisier(best) + max(TIED * explained, OF_LEFT * found.inexact(best), UNFORETOLD * unforetold)
    near = [each for each in rivals if found.cost(each) - found.cost(best) <= allowed]
    kept = [best]
    for each in sorted(near, key=found.cost):
        wider = any(
            len(each.after) > len(other.after) and (each.square >= other.square or each.suspect.contains(other.suspect))
            for other in near
        )
        extended = any(set(other.suspect.names) < set(each.suspect.names) for other in near)
        if each is not best and not wider and not extended:
            kept.append(each)
    return kept


def _nothing(found: Found) -> ChangeVerdict:
    before, scatter = found.frame.off(), found.frame.scatter
    beyond = sqrt(max(0.0, before**2 - scatter**2))
    difference = Difference(before, before, scatter, 0.0)
    if (found.left(found.frame.seen) or before > FARTHER * scatter) and beyond >= found.frame.pair.worth:
        said = (
            f"Something has changed, by {millimetres(beyond)} beyond the scatter of trials, and no candidate surely explains it."
        )
        return ChangeVerdict("unexplained", (), (), said, difference=difference)
    limits = {fitted.suspect.names[0]: _limit(found, fitted, seen) for fitted, seen in found.fits if len(fitted.after) == 1}
    words = {"keq_scale": "stiffness", "damping_scale": "damping"}
    seen_from = [f"of {words[name]} by {100 * limits[name]:.2g} %" for name in words if name in limits]
    would = f" A change {' or '.join(seen_from)} would have shown." if seen_from else ""
    said = (
        f"Nothing has changed that shows: what the first recording foretells of the second is {millimetres(before)} off, and "
        f"{millimetres(scatter)} would be no surprise.{would}"
    )
    return ChangeVerdict("unchanged", (), (), said, difference=difference, limits=limits)


def _limit(found: Found, fitted: Fitted, frame: Frame) -> float:
    """Size that a change would need to be taken for one, relative where it has one in OLD."""
    slope, start = fitted.slopes[:, 0], float(fitted.suspect.start[0])
    by_gain = sqrt(found.needed(fitted) / max(float(slope @ slope), 1e-300))
    moved, step = fitted.rms, abs(float(fitted.after[0]) - start)
    by_size = found.frame.pair.worth * step / moved if moved > 0 else 0.0
    return max(by_gain, by_size) / (start if start else 1.0)
