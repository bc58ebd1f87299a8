"""What counts: when a model is better than another, as good, or good enough."""

from __future__ import annotations

from dataclasses import dataclass

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.evidence import certainly_better, squares, structure
from hsr_pin.identification.uncertainty import clearness

#: An effect is named only if its amplitude is at least so many standard errors away from neutral. Fits are sure of a law that is
#: in the recordings; one that is stretched over another's traces rests on a few samples.
SURE = 8.0
#: A rival is set aside only if its mean square is certainly larger, and by at least this share of what the best leaves ...
FACTOR = 0.5
#: (of that at least this share counts as wrong, however badly the arm repeats itself) ...
REPEATED = 0.2
#: ... plus the square of this share of the noise floor.
MARGIN = 0.05


@dataclass(frozen=True)
class Thresholds:
    """What counts.

    Attributes:
        noise: [m] RMS distance that noise alone leaves.
        worth: [m] an effect is worth having if it takes this much RMS distance away (square root of the drop of the mean square).
        closed: [m] an RMS distance beyond noise that is too small to ask about.
        unrepeatable: [m] RMS distance of the arm from itself in trials that repeat one another; 0 where none do.
        explained: largest share of the squared gap that may be left when effects are said to explain it ...
        corner: ... and the largest RMS distance, over the one that is too small to ask about.
        substantial: share of the squared gap that an effect must take away ...
        remnant: ... if it leaves more than this share of what the others leave: it may be what is wrong with
            another effect's law.
    """

    noise: float
    worth: float
    closed: float
    unrepeatable: float = 0.0
    explained: float = 0.03
    corner: float = 5.0
    substantial: float = 0.10
    remnant: float = 0.25

    @classmethod
    def of(cls, noise: float, length: float, unrepeatable: float | None = None) -> Thresholds:
        """For a noise floor [m], an arm of this length [m], and how far it is from itself [m], where that is known."""
        return cls(noise, max(0.4 * noise, 1e-3 * length), max(0.3 * noise, 0.75e-3 * length), unrepeatable or 0.0)


def mean_square(candidate: Candidate) -> float:
    """[m^2] on held-out trials."""
    return squares(candidate.heldout).mean


def left(candidate: Candidate) -> float:
    """[m^2] mean square on held-out trials that is not noise."""
    return structure(candidate.heldout)


def open_share(candidate: Candidate, base: Candidate, thresholds: Thresholds) -> float:
    """Share of the squared gap that a model leaves, beyond what does not repeat."""
    return max(0.0, left(candidate) - thresholds.unrepeatable**2) / max(left(base), 1e-300)


def explains(candidate: Candidate, base: Candidate, thresholds: Thresholds) -> bool:
    """Whether a model leaves next to nothing: of noise, or of a large gap."""
    rest, closed = left(candidate), thresholds.closed**2
    return rest <= closed or (rest <= thresholds.explained * left(base) and rest <= thresholds.corner**2 * closed)


def doubtful(candidate: Candidate, least: float = SURE) -> tuple[str, ...]:
    """Effects of a fitted model whose size is less than so many standard errors from none."""
    clear = clearness(candidate.fit)
    return tuple(name for name in candidate.names if clear.get(name, 0.0) < least)


def worth_having(worse: Candidate, better: Candidate, thresholds: Thresholds, seed: int) -> bool:
    """Whether a gain is both certain and worth having."""
    much = mean_square(worse) - mean_square(better) >= thresholds.worth**2
    return much and certainly_better(better.heldout, worse.heldout, seed)


def clearly_worse(candidate: Candidate, than: Candidate, thresholds: Thresholds, seed: int) -> bool:
    """Whether a model's mean square is larger, certainly and by an amount that counts."""
    much = mean_square(candidate) - mean_square(than) > tolerated(than, thresholds)
    return much and certainly_better(than.heldout, candidate.heldout, seed)


def matches(rival: Candidate, best: Candidate, base: Candidate, thresholds: Thresholds, seed: int) -> bool:
    """Whether a model does about what the best does: it takes away half as much at least, and is not clearly worse."""
    enough = left(base) - left(rival) >= FACTOR * (left(base) - left(best))
    return enough and not clearly_worse(rival, best, thresholds, seed)


def tolerated(best: Candidate, thresholds: Thresholds) -> float:
    """[m^2] difference of mean squares by which a model may be worse than the best and not be told from it: neither is exact.

    What does not repeat from trial to trial is no fault of a model.
    """
    wrong = max(left(best) - thresholds.unrepeatable**2, REPEATED * left(best))
    return FACTOR * wrong + (MARGIN * thresholds.noise) ** 2
