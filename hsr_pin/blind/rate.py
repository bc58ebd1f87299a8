"""Rate of hits with its confidence interval."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Rate:
    """Number of hits out of a total, with the exact 95 % interval (C. J. Clopper, E. S. Pearson, Biometrika 26, 1934)."""

    hits: int
    of: int

    @classmethod
    def among(cls, answers: Iterable[bool]) -> Rate:
        """Return the rate of true answers."""
        known = list(answers)
        return cls(sum(known), len(known))

    @property
    def share(self) -> float:
        """Share of hits, 0 to 1; NaN if there is no case."""
        return self.hits / self.of if self.of else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Exact 95 % confidence interval of the share."""
        from scipy.stats import binomtest

        if not self.of:
            return 0.0, 1.0
        low, high = binomtest(self.hits, self.of).proportion_ci()
        return float(low), float(high)

    def document(self) -> dict[str, Any]:
        """Return the rate as a JSON document."""
        return {"hits": self.hits, "of": self.of, "ci95": list(self.interval)}

    def __str__(self) -> str:
        if not self.of:
            return "no case"
        low, high = self.interval
        return f"{100 * self.share:.0f} % ({self.hits} of {self.of}; {100 * low:.0f} to {100 * high:.0f} %)"
