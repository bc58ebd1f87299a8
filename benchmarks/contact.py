"""Time to simulate 1 s of arms that swing against obstacles, to a given error of the tip.

    python benchmarks/contact.py     print the table (about one minute)

Both simulate the same bodies, capsules and obstacles: the model of MuJoCo is the exported one. The contact laws differ, so that
each is compared with its own converged motion. MuJoCo gets the best of all its integrators.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache, partial

import numpy as np
from ours import METHODS, TOLERANCES, Ours, tolerant
from problem import DURATION, SAMPLE, TORQUE, Solver, tip_error
from rows import Row, Title, seconds
from search import PATIENCE, SUBSTEPS, cheapest, medians

from hsr_pin.obstacles import Cylinder, Obstacle
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.integrator import Integrator
from hsr_pin.trajectory import Array

CORES, ARMS, LINKS = 2, 1000, 16
ERRORS = (1.0, 0.1)  # [mm]
#: Of a converged motion: tolerance of hsr_pin [m], and steps per sample of MuJoCo.
_FINE, _STEPS = 1e-8, 400
#: MuJoCo is timed on one arm in so many.
_SHARE = 50
_POST = (Cylinder(centre=(0.06, 0.0, -0.14), radius=0.01),)
#: Ten posts around the tip's path; the arm touches some of them.
_POSTS = tuple(
    Cylinder(centre=(0.06 + 0.03 * k, 0.0, z), radius=0.005) for k, z in enumerate((-0.14, -0.1, -0.06, -0.2, -0.24))
) + tuple(Cylinder(centre=(-0.06 - 0.03 * k, 0.0, z), radius=0.005) for k, z in enumerate((-0.14, -0.1, -0.06, -0.2, -0.24)))


def titles() -> list[Title]:
    """Return the lines of this measurement."""
    one = [Title(f"1 s of a swing against a post to {error:g} mm, N = {LINKS}", "MuJoCo", "mujoco", 30.0) for error in ERRORS]
    return [*one, _many(ARMS)]


def _many(count: int) -> Title:
    task = f"1 s of {count:,} arms among ten posts to {ERRORS[0]:g} mm, N = {LINKS}, {CORES} cores"
    return Title(task, "mujoco.rollout", "mujoco", 30.0)


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured lines; quick: the first of them."""
    arm = _arm(1.0, _POST)
    for title, error in zip(titles()[:1] if quick else titles()[:-1], ERRORS, strict=False):
        own = _ours([arm], error)
        yield _row(title, own, _theirs([arm], error) if title.installed else None, 1)
    if not quick:
        arms = [_arm(factor, _POSTS) for factor in np.random.default_rng(4).uniform(0.8, 1.2, ARMS).tolist()]
        own = Ours(arms, _ours(arms[:: 10 * _SHARE], ERRORS[0]).method, threads=CORES)
        theirs = _theirs(arms[::_SHARE], ERRORS[0]) if titles()[-1].installed else None
        yield _row(_many(ARMS), own, theirs, _SHARE / CORES)


def _row(title: Title, own: Ours, theirs: Solver | None, share: float) -> Row:
    """Return a line; the peer's time counts ``share`` times."""
    times = medians({"ours": own.run} | ({"theirs": theirs.run} if theirs else {}), 5)
    words = f"{seconds(times['ours'])} ({own.setting})"
    if theirs is None:
        return Row(title, words, "not installed" if not title.installed else f"not within {PATIENCE:g} s")
    taken = times["theirs"] * share
    return Row(title, words, f"{seconds(taken)} ({theirs.setting})", taken / times["ours"])


def _arm(stiffness: float, obstacles: tuple[Obstacle, ...]) -> ArmSpecification:
    return ArmSpecification(links=LINKS, placement="mid", keq=1.11 * stiffness, obstacles=obstacles)


def _ours(arms: Sequence[ArmSpecification], error: float) -> Ours:
    exact = Ours(arms, Integrator("extrapolated4", _FINE)).run()
    found = cheapest(
        [partial(tolerant, arms, name) for name in METHODS],
        TOLERANCES,
        lambda angles: tip_error(list(arms), angles, exact) <= error,
    )
    assert isinstance(found, Ours)
    return found


def _theirs(arms: Sequence[ArmSpecification], error: float) -> Solver | None:
    from peer_mujoco import METHODS as INTEGRATORS

    exact = Touching(arms, "implicit", _STEPS).run()
    makes = [partial(Touching, arms, method) for method in INTEGRATORS]
    return cheapest(makes, SUBSTEPS, lambda angles: tip_error(list(arms), angles, exact) <= error)


class Touching:
    """A solver by MuJoCo for arms with obstacles, one after the other.

    Args:
        arms: the arms.
        method: integrator.
        substeps: steps per sample.
    """

    def __init__(self, arms: Sequence[ArmSpecification], method: str, substeps: int) -> None:
        import mujoco
        from peer_mujoco import METHODS as INTEGRATORS

        step = SAMPLE / substeps
        self.substeps, self.setting = substeps, f"{method}, {1e3 * step:.3g} ms"
        self._step, self._reset, self._pairs = mujoco.mj_step, mujoco.mj_resetData, []
        for arm in arms:
            model = mujoco.MjModel.from_xml_string(_exported(arm))
            model.opt.timestep, model.opt.integrator = step, INTEGRATORS[method]
            self._pairs.append((model, mujoco.MjData(model)))

    def run(self) -> Array:
        """Return the joint angles, see `Solver`."""
        angles = np.zeros((round(DURATION / SAMPLE) + 1, len(self._pairs), LINKS))
        for b, (model, data) in enumerate(self._pairs):
            self._reset(model, data)
            data.ctrl[0] = TORQUE
            for n in range(1, len(angles)):
                self._step(model, data, nstep=self.substeps)
                angles[n, b] = data.qpos
        return angles


@lru_cache(maxsize=256)
def _exported(arm: ArmSpecification) -> str:
    import mujoco

    from hsr_pin.export.mjcf import to_mjcf
    from hsr_pin.export.model import CorrectedModel

    return to_mjcf(CorrectedModel(arm), major=int(mujoco.__version__.split(".")[0])).text


if __name__ == "__main__":
    from run import document

    print(document(list(measure(quick=False))), end="")
