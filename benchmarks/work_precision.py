"""Time to simulate 1 s of one arm to a given tip error, each solver with its cheapest setting that reaches the error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

from exact import exact_motion
from problem import SAMPLE, Solver, tip_error
from rows import Row, Title, seconds
from search import PATIENCE, SUBSTEPS, TOLERANCES, Make, cheapest, medians

from hsr_pin.robot.specification import ArmSpecification

#: Name of a peer and the module it needs; SciPy comes with hsr_pin.
PEERS = {"MuJoCo": "mujoco", "SciPy Radau": "", "SciPy LSODA": "", "PyBullet": "pybullet"}


@dataclass(frozen=True)
class Case:
    """One comparison.

    Attributes:
        links: number of links of the arm.
        error: error of the tip [mm].
        sample: time between samples [s].
        peers: names of the peers.
        reach: target of the speed relative to MuJoCo, and relative to SciPy's LSODA.
    """

    links: int
    error: float
    sample: float = SAMPLE
    peers: tuple[str, ...] = ("MuJoCo",)
    reach: tuple[float | None, float | None] = (None, None)

    def titles(self) -> list[Title]:
        """Return the lines of this comparison."""
        often = "" if self.sample == SAMPLE else f", a sample every {1e3 * self.sample:g} ms"
        task = f"1 s of the step to {self.error:g} mm, N = {self.links}{often}"
        reach = dict(zip(("MuJoCo", "SciPy LSODA"), self.reach, strict=True))
        return [Title(task, peer, PEERS[peer], reach.get(peer)) for peer in self.peers]


CASES = (
    Case(4, 1.0, reach=(1.0, None)),
    Case(4, 1.0, sample=0.01, reach=(1.0, None)),
    Case(4, 0.1, peers=tuple(PEERS), reach=(10.0, 10.0)),
    Case(4, 0.1, sample=0.01, reach=(10.0, None)),
    Case(4, 0.01, peers=tuple(PEERS), reach=(10.0, 10.0)),
    Case(4, 0.01, sample=0.01, reach=(10.0, None)),
    Case(16, 1.0),
    Case(16, 0.1, peers=tuple(PEERS)),
    Case(16, 0.01, peers=tuple(PEERS)),
)


def titles() -> list[Title]:
    """Return the lines of this measurement."""
    return [title for case in CASES for title in case.titles()]


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured lines; quick: those of the first case."""
    for case in CASES[:1] if quick else CASES:
        wanted = case.titles()
        names = ["hsr_pin", *(title.peer for title in wanted if title.installed)]
        found = {name: solver_of(name, case.links, case.error, case.sample) for name in names}
        solvers = {name: solver for name, solver in found.items() if solver is not None}
        times = medians({name: solver.run for name, solver in solvers.items()}, 3 if quick else 21)
        words = {name: f"{seconds(times[name])} ({solver.setting})" for name, solver in solvers.items()}
        own, taken = words["hsr_pin"], times["hsr_pin"]
        for title in wanted:
            if title.peer in solvers:
                yield Row(title, own, words[title.peer], times[title.peer] / taken)
            elif title.installed:
                yield Row(title, own, f"not within {PATIENCE:g} s", PATIENCE / taken, above=True)
            else:
                yield Row(title, own)


@lru_cache(maxsize=64)
def solver_of(name: str, links: int, error: float, sample: float = SAMPLE) -> Solver | None:
    """Return the cheapest accurate solver of one name for ``links`` and an error [mm]; None if there is none."""
    arm, exact = ArmSpecification(links=links), exact_motion(links, sample)
    ladder: Sequence[float] = SUBSTEPS
    families: list[Make]
    if name == "hsr_pin":
        from ours import METHODS, tolerant
        from ours import TOLERANCES as ladder

        families = [partial(tolerant, [arm], method, sample=sample) for method in METHODS]
    elif name == "MuJoCo":
        import peer_mujoco

        families = [partial(peer_mujoco.MujocoChain, arm, method, sample=sample) for method in peer_mujoco.METHODS]
    elif name == "PyBullet":
        from peer_pybullet import PybulletChain

        families = [partial(PybulletChain, arm)]
    else:
        from peer_scipy import ScipyChain

        families, ladder = [partial(ScipyChain, arm, name.removeprefix("SciPy "), sample=sample)], TOLERANCES
    return cheapest(families, ladder, lambda angles: tip_error([arm], angles, exact) <= error)
