"""Latency of one step of 5 or 10 ms under a new torque for a controller in Python: median and 99th percentile."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import ceil
from time import perf_counter

import numpy as np
from problem import SAMPLE
from rows import Row, Title, seconds
from work_precision import solver_of

from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.robot.specification import ArmSpecification

#: Links of the arm and length of the step [s].
CASES = ((4, 0.005), (4, 0.01), (10, 0.01))
#: [mm] of the tip over 1 s of the step: what ours keeps as it comes, with steps of 10 ms or less.
ERROR = 0.01
_TORQUES = (0.25 * np.sin(0.05 * np.arange(200))).tolist()  # [N m]
_ROUNDS = 10


def titles() -> list[Title]:
    """Return the lines of this measurement."""
    return [title for case in CASES for title in _titles(*case)]


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured lines; quick: the one that needs no search."""
    for links, dt in CASES[:1] if quick else CASES:
        accurate, single = _titles(links, dt)
        simulator = ArmSimulator(ArmSpecification(links=links))
        steps: dict[str, Callable[[float], object]] = {"hsr_pin": partial(simulator.step, dt=dt)}
        if single.installed:
            steps[single.peer] = _mujoco(links, dt, None)
            if not quick:
                steps[accurate.peer] = _mujoco(links, dt, ERROR)
        waits = _waits(steps, 1 if quick else _ROUNDS)
        for title in (single,) if quick else (accurate, single):
            own = waits["hsr_pin"]
            taken = waits.get(title.peer)
            yield Row(title, _words(own)) if taken is None else Row(title, _words(own), _words(taken), taken[0] / own[0])


def _titles(links: int, dt: float) -> tuple[Title, Title]:
    """Return the lines for MuJoCo at the accuracy of hsr_pin, and for a single step of MuJoCo at any accuracy."""
    wanted = ", ours at most 8 µs" if dt == 0.005 else ""
    task = f"a step of {1e3 * dt:g} ms from Python, N = {links}: median (99th percentile){wanted}"
    return Title(task, f"MuJoCo to {ERROR} mm", "mujoco"), Title(task, "MuJoCo, one `mj_step`, to no accuracy", "mujoco")


def _mujoco(links: int, dt: float, error: float | None) -> Callable[[float], object]:
    """Return a function that steps MuJoCo in its cheapest setting for an error [mm]; None: with a single step."""
    from peer_mujoco import MujocoChain

    arm = ArmSpecification(links=links)
    chain = MujocoChain(arm, "Euler", round(SAMPLE / dt)) if error is None else solver_of("MuJoCo", links, error)
    assert isinstance(chain, MujocoChain)
    count = ceil(chain.substeps * dt / SAMPLE)

    def step(torque: float) -> None:
        chain.model.qpos_spring[:] = torque / arm.joint_stiffness
        chain.advance(count)

    return step


def _words(wait: tuple[float, float]) -> str:
    return f"{seconds(wait[0])} ({seconds(wait[1])})"


def _waits(steps: dict[str, Callable[[float], object]], rounds: int) -> dict[str, tuple[float, float]]:
    """Return median and 99th percentile of each step function's time [s], measured in turns."""
    times: dict[str, list[float]] = {name: [] for name in steps}
    for _ in range(rounds):
        for name, step in steps.items():
            for torque in _TORQUES:
                begin = perf_counter()
                step(torque)
                times[name].append(perf_counter() - begin)
    return {name: (float(np.percentile(taken, 50)), float(np.percentile(taken, 99))) for name, taken in times.items()}
