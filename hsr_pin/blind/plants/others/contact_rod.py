"""A soft planar arm as a discrete elastic rod with contact: one plant for blind tests of a diagnosis program.

The rod is the planar case of Bergou et al. 2008 ("Discrete elastic rods"): the unknowns are the node positions, bending sits at
the vertices (the clamp has half a cell), a stretching spring EA keeps the length. Steps are BDF2, the first one backward Euler.
Contacts are penalties: Hunt and Crossley 1975 across the surface, Cundall and Strack 1979 (spring and Coulomb slider) along it.
Inner coordinates: X along the straight arm, Y across it (world x). The torque runs linearly between the rows of a CSV (INPUT =
"hold" keeps it until the next row). A release is a sideways pull on the tip at zero torque, settled, let go at the first row or
at `t_start`. Several laws are sized one after the other, each on top of those before. `python contact_rod.py` checks the rod.
"""
from __future__ import annotations

import sys
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from scipy.interpolate import CubicSpline
from scipy.signal import butter, savgol_filter, sosfiltfilt

Array = np.ndarray
LENGTH, MASS, DIAMETER, GRAVITY, EA = 0.24, 0.15, 0.04, 9.81, 2e5  # m, kg, m, m/s^2, N
INPUT = "linear"  # or "hold"
FINE, COARSE = (32, 1e-3), (16, 2.5e-3)  # edges and longest time step [s]; the coarse pair only serves to find a strength
FLOORS, CAP = {"barely": 2.0, "medium": 6.0, "large": 15.0}, 12.0  # gaps in noise floors, and their cap in mm

NAMES = {
    "elastic": "stiffness_gradient soft_spot preset_bend stiffening bending_stop backlash", "friction": "dry_friction hysteresis",
    "creep": "viscoelastic", "damping": "quadratic_damping damping_gradient",
    "actuation_time": "actuator_lag unequal_lag dead_time", "actuation_map": "torque_bias torque_map torque_decay",
    "mass_gravity": "gravity_tilt tip_mass added_mass", "measurement": "marker_offset marker_slip", "contact": "restraint",
}
CATALOGUE: dict[str, tuple[str, ...]] = {name: (kind,) for kind, names in NAMES.items() for name in names.split()}
OUTSIDE: dict[str, tuple[str, ...]] = {
    "post_midway": ("contact",),  # a round post half-way along the arm, on one side
    "band_midway": ("contact",),  # a rubber band tied on half-way, or a taut hose strung beside that place
    "floor_under_tip": ("contact",),  # a sloping floor that the tip drags over (hanging) or lands on (upright)
    "stress_softening": ("elastic",),  # Mullins effect (Ogden and Roxburgh 1999): softer below the largest bending so far
    "slew_limit": ("actuation_time",),  # the torque changes at a bounded rate
}


class Rod(NamedTuple):
    """What the compiled steps need. "Bending" is the angle [rad] that the whole arm would have at the local curvature."""

    per: Array  # (n,) bending for each rad of turning angle
    k: Array  # (n,) stiffness, Nm per rad of bending; a factor on the declared one until a trial is played
    c: Array  # (n,) damping, Nm s/rad; likewise
    rest: Array  # (n,) bending at rest, rad
    drive: Array  # (n,) share of the torque that arrives
    mass: Array  # (n + 1,) kg
    gravity: Array  # (2,) m/s^2 along X and Y
    jenkins: Array  # (j, 2) stiffness [Nm/rad] and slip moment [Nm] of parallel sliders
    maxwell: Array  # (q, 2) stiffness as a share of k, relaxation time [s]
    points: Array  # (p, 11) contacts: shape, edge, place on it, stiffness, tangential stiffness, mu, five numbers of geometry
    h: float  # rest length of an edge, m
    drag: float  # N s^2/m^2 on a node, quadratic drag of the medium
    clamp: float = 0.0  # direction of the clamp, rad
    hard: float = 0.0  # 1/rad^2, cubic hardening
    soft: float = 0.0  # 1/rad, softening to two fifths of the stiffness
    stop: float = 1e3  # bending beyond which the links lock, rad
    play: float = 0.0  # half-width of the loose range, rad
    mullins: float = 0.0  # share of the stiffness lost below the peak
    quad: float = 0.0  # Nm s^2/rad^2


class State(NamedTuple):
    """Everything that a step carries on to the next one."""

    x: Array  # (2, n + 1, 2) positions now and before, m
    v: Array  # (2, n + 1, 2) velocities, m/s
    turn: Array  # (2, n) turning angles, rad
    slip: Array  # (n, j) places of the sliders, rad
    branch: Array  # (n, q) moments of the Maxwell branches, Nm
    peak: Array  # (n,) largest bending so far, rad
    stick: Array  # (p,) tangential stretch of the contacts, m


@njit(cache=True)
def moment(rod, st, i, turn, rate, torque, dt, commit):
    """Return the moment [Nm] that vertex i holds against a turning angle [rad]; `commit` updates its memories."""
    b, k = turn * rod.per[i] - rod.rest[i], rod.k[i]
    e = b - 0.8 * min(max(b, -rod.play), rod.play)  # a fifth of the stiffness (the skin) is left inside the play
    m = k * e * (1.0 + rod.hard * e * e - 0.6 * (1.0 - 1.0 / np.sqrt(1.0 + (rod.soft * e) ** 2)))
    m *= 1.0 - rod.mullins * np.tanh(max(0.0, st.peak[i] - abs(b)) / 0.25)
    past = b - min(max(b, -rod.stop), rod.stop)
    m += 25.0 * k * past * abs(past) / (abs(past) + 0.05) + (rod.c[i] + rod.quad * abs(rate)) * rate - torque * rod.drive[i]
    for j in range(rod.jenkins.shape[0]):
        reach = rod.jenkins[j, 1] / rod.jenkins[j, 0]
        moved = min(max(st.slip[i, j], b - reach), b + reach)
        m += rod.jenkins[j, 0] * (b - moved)
        st.slip[i, j] = moved if commit else st.slip[i, j]
    for q in range(rod.maxwell.shape[0]):  # exact for a steady rate within the step (Simo and Hughes 1998, chapter 10)
        a = dt / rod.maxwell[q, 1]
        grown = rod.maxwell[q, 0] * k * (turn - st.turn[0, i]) * rod.per[i] * (1.0 - np.exp(-a)) / a
        new = st.branch[i, q] * np.exp(-a) + grown
        m += new
        st.branch[i, q] = new if commit else st.branch[i, q]
    st.peak[i] = max(st.peak[i], abs(b)) if commit else st.peak[i]
    return m


@njit(cache=True)
def touch(row, p, v, moved, stick):
    """Return the contact force [N] on a point of the arm at p with velocity v, and its tangential stretch [m]."""
    k, g, f, size, along = row[3], row[6:], np.zeros(2), 0.0, np.array([1.0, 0.0])
    r = np.hypot(g[0] - p[0], g[1] - p[1])
    normal = (g[:2] - p) / r
    if row[0] == 1.0:  # a post around (g0, g1) of radius g2 (a kilometre makes a wall)
        speed = v[0] * normal[0] + v[1] * normal[1]
        size, along = k * max(0.0, g[2] - r) ** 1.5 * max(0.0, 1.0 + 1.5 * speed), np.array([-normal[1], normal[0]])
        f = -size * normal
    elif row[0] == 2.0:  # a band tied to the point, led through an eyelet at (g0, g1), slack below its rest length g2
        size, along = k * max(0.0, r - g[2]), -normal
        f = size * normal
    elif (p[1] - g[2]) * g[3] > 0.0:  # a hose strung from X = g0 to g1 at Y = g2, on the side g3; tension k, stretching g4
        one, two = p - np.array([g[0], g[2]]), p - np.array([g[1], g[2]])
        a, b = np.hypot(one[0], one[1]), np.hypot(two[0], two[1])
        f = -k * (1.0 + g[4] * ((a + b) / abs(g[1] - g[0]) - 1.0)) * (one / a + two / b)
        size = np.hypot(f[0], f[1])
    if size <= 0.0 or row[5] <= 0.0:
        return f, 0.0
    most = row[5] * size / row[4]
    stick = min(max(stick + moved[0] * along[0] + moved[1] * along[1], -most), most)
    return f - row[4] * stick * along, stick


@njit(cache=True)
def residual(rod, st, x, torque, pull, dt, c, mode, line):
    """Return the forces out of balance on the free nodes [N] for BDF coefficients c; mode 1 also advances the state."""
    # mode 2 also writes the moments, their slopes and the angles into `line`; mode 3 takes the moments from these lines
    n, e, m = rod.k.size, x[1:] - x[:-1], np.zeros(rod.k.size + 1)
    length, angle = np.sqrt(e[:, 0] ** 2 + e[:, 1] ** 2), np.arctan2(e[:, 1], e[:, 0])
    turn = angle.copy()
    turn[0] -= rod.clamp
    turn[1:] -= angle[:-1]
    rate = (c[0] * turn + c[1] * st.turn[0] + c[2] * st.turn[1]) / dt * rod.per
    for i in range(n):
        if mode == 3:
            m[i] = line[i, 0] + line[i, 1] * (turn[i] - line[i, 2])
            continue
        m[i] = moment(rod, st, i, turn[i], rate[i], torque, dt, mode == 1)
        if mode == 2:
            near = moment(rod, st, i, turn[i] + 1e-8, rate[i] + 1e-8 * c[0] / dt * rod.per[i], torque, dt, False)
            line[i] = m[i], (near - m[i]) * 1e8, turn[i]
    v = (c[0] * x + c[1] * st.x[0] + c[2] * st.x[1]) / dt
    r = (c[0] * v + c[1] * st.v[0] + c[2] * st.v[1]) / dt
    for i in range(n + 1):
        r[i] = rod.mass[i] * (r[i] - rod.gravity) + rod.drag * np.hypot(v[i, 0], v[i, 1]) * v[i]
    for i in range(n):  # the couple on the edge, as forces on its two ends, and its tension
        couple, axial = (m[i] - m[i + 1]) / length[i] ** 2, EA * (1.0 / rod.h - 1.0 / length[i])
        fx, fy = axial * e[i, 0] - couple * e[i, 1], axial * e[i, 1] + couple * e[i, 0]
        r[i, 0], r[i, 1], r[i + 1, 0], r[i + 1, 1] = r[i, 0] - fx, r[i, 1] - fy, r[i + 1, 0] + fx, r[i + 1, 1] + fy
    r[n, 1] -= pull
    for j in range(rod.points.shape[0]):
        i, w = int(rod.points[j, 1]), rod.points[j, 2]
        p, o, s = (1.0 - w) * x[i] + w * x[i + 1], (1.0 - w) * st.x[0, i] + w * st.x[0, i + 1], (1.0 - w) * v[i] + w * v[i + 1]
        f, stick = touch(rod.points[j], p, s, p - o, st.stick[j])
        r[i] -= (1.0 - w) * f
        r[i + 1] -= w * f
        st.stick[j] = stick if mode == 1 else st.stick[j]
    if mode == 1:
        st.x[1], st.v[1], st.turn[1] = st.x[0], st.v[0], st.turn[0]
        st.x[0], st.v[0], st.turn[0] = x, v, turn
    return r[1:].copy().reshape(2 * n)


@njit(cache=True)
def invert(rod, st, x, torque, pull, dt, c):
    """Return the inverse of the derivative of the residual by the free positions, found by differences."""
    line, size = np.zeros((rod.k.size, 3)), 2 * rod.k.size
    r, a = residual(rod, st, x, torque, pull, dt, c, 2, line), np.zeros((size, size))
    for group in range(10):  # the nodes 1, 6, 11, ... have no neighbour in common, so they are moved together
        y = x.copy()
        y[group // 2 + 1::5, group % 2] += 1e-8
        s = (residual(rod, st, y, torque, pull, dt, c, 3, line) - r) * 1e8
        for column in range(group, size, 10):
            first, last = max(0, column - group % 2 - 4), column - group % 2 + 6
            a[first:last, column] = s[first:last]
    return np.linalg.inv(a)


@njit(cache=True)
def step(rod, st, torque, pull, dt, second, inverse):
    """Advance the state by dt under a torque [Nm] and a sideways pull on the tip [N]. Return whether Newton converged."""
    c = (1.5, -2.0, 0.5) if second else (1.0, -1.0, 0.0)
    x, last, before = st.x[0] + (dt if dt < 0.01 else 0.0) * st.v[0], 0.0, 0.0
    for trip in range(80):
        if (trip == 0 and inverse[0, 0] == 0.0) or (trip > 0 and last > 0.3 * before):  # else that of an earlier step serves
            inverse[:] = invert(rod, st, x, torque, pull, dt, c)
        u = inverse @ residual(rod, st, x, torque, pull, dt, c, 0, inverse)
        before, last = last if trip else 1e-3, np.max(np.abs(u))
        x[1:] -= min(1.0 if trip < 20 else 0.5, 0.02 / (last + 1e-30)) * u.reshape(x[1:].shape)
        if last < 1e-8:
            residual(rod, st, x, torque, pull, dt, c, 1, inverse)
            return True
    return False


@njit(cache=True)
def run(rod, st, torque, each, dt):
    """Return the node positions at every `each`-th time of the torque series, and whether every step converged."""
    size, good = 2 * rod.k.size, True
    out, inverse = np.zeros(((torque.size - 1) // each + 1, rod.k.size + 1, 2)), np.zeros((size, size))
    for i in range(torque.size):
        good = good and (i == 0 or step(rod, st, torque[i], 0.0, dt, i > 1, inverse))
        if i % each == 0:
            out[i // each] = st.x[0]
    return out, good


@njit(cache=True)
def follow(target, dt, fill, vent, rate):
    """Return a chamber's torque after a first-order lag with two time constants [s] and a bounded rate [Nm/s]."""
    out = target.copy()
    for i in range(1, target.size):
        aim = 0.5 * (target[i] + target[i - 1]) - out[i - 1]
        out[i] = out[i - 1] + min(max(aim * (1.0 - np.exp(-dt / (fill if aim > 0.0 else vent))), -rate * dt), rate * dt)
    return out


class Trial(NamedTuple):
    """One recording: its program, declared values, row times, command, the pull before a release [N] and the release's row."""

    program: str
    keq: float
    damping: float
    t: Array
    tau: Array
    pull: float
    start: int


@dataclass
class Arm:
    """The true arm, which the laws alter."""

    rod: Rod
    act: list[Callable[[Array, float], Array]]  # from a torque series [Nm] and its time step [s] to the torque that acts
    place: Array  # (markers,) s / L where they truly sit
    offset: Array  # (markers,) m off the neutral line, to the left

    def play(self, trial: Trial, longest: float, pose: Array | None = None) -> tuple[Array, Array, Array]:
        """Return node positions (rows, n + 1, 2), marker positions [m] and the edge directions at the start [rad].

        `pose` (edge directions) replaces the pose from which the arm is released. Raises ValueError if a step fails.
        """
        rod = self.rod._replace(k=self.rod.k * trial.keq, c=self.rod.c * trial.damping)
        n, gap, good = rod.k.size, float(trial.t[1] - trial.t[0]), True
        each = int(np.ceil(gap / longest - 1e-9))
        rows = np.arange((trial.t.size - 1) * each + 1) / each
        torque = np.interp(np.floor(rows + 1e-9) if INPUT == "hold" else rows, np.arange(trial.t.size), trial.tau)
        for act in filter(None, self.act):
            torque = act(torque, gap / each)
        straight = rod.h * np.outer(np.arange(n + 1), [np.cos(rod.clamp), np.sin(rod.clamp)])
        st = State(np.array([straight] * 2), np.zeros((2, n + 1, 2)), np.zeros((2, n)), np.zeros((n, len(rod.jenkins))),
                   np.zeros((n, len(rod.maxwell))), np.zeros(n), np.zeros(len(rod.points)))
        for load in [*np.linspace(0.0, 1.0, 31)[1:], 2.0, 2.0, 2.0, 2.0]:  # load slowly, then wait until nothing moves
            part, dt = min(load, 1.0), 0.1 if load <= 1.0 else 1e3
            good = good and step(rod, st, part * torque[0], part * trial.pull, dt, False, np.zeros((2 * n, 2 * n)))
        if trial.pull and pose is not None:
            st.x[0, 1:] = np.cumsum(rod.h * np.column_stack([np.cos(pose), np.sin(pose)]), 0)
            st.turn[0] = np.diff(pose, prepend=rod.clamp)
        st.x[1], st.turn[1], st.v[:], edges = st.x[0], st.turn[0], 0.0, np.diff(st.x[0], axis=0)
        nodes, done = run(rod, st, torque[trial.start * each:], each, gap / each)
        if not (good and done):
            raise ValueError("the solver does not converge")
        nodes = np.concatenate([np.repeat(nodes[:1], trial.start, 0), nodes])
        curve, spots = CubicSpline(np.arange(n + 1), nodes, axis=1), self.place * n
        across = curve(spots, 1) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        seen = curve(spots) + self.offset[:, None] * across / np.linalg.norm(across, axis=2)[..., None]
        return nodes, seen, np.arctan2(edges[:, 1], edges[:, 0])


def contact(rod: Rod, middle: bool, shape: str, x: float, side: float, mu: float, u: Array, paths: Array) -> dict[str, Any]:
    """Return the rod's contacts with one more of strength x at the tip or at mid-length, and its parameters."""
    n, path, x0 = rod.k.size, paths[:, paths.shape[1] // 2 if middle else -1], LENGTH * (0.5 if middle else 1.0)
    spot, reach, down = [n // 2, 0.0] if middle else [n - 1, 1.0], float(np.max(side * path[:, 1])), np.sign(rod.gravity[0])
    if shape in ("wall", "floor"):  # as x grows it comes from the farthest place of the free tip to that of the straight arm
        slope = 0.3 * u[0] + 0.35 * (down > 0.0) if shape == "floor" else 0.3 * (u[0] - 0.5)
        along, across = np.cos(slope), np.sin(slope)
        normal = np.array([down * along, side * across] if shape == "floor" else [across, side * along])
        far = float(np.max(path @ normal))
        rows = [[1.0, *spot, 3e5, 2e4, mu, *(normal * (far - x * (far - x0 * normal[0]) + 1e3)), 1e3, 0.0, 0.0]]
    elif shape == "band":
        eye = x0 + 0.06 * (u[0] - 0.5), side * (0.1 + 0.05 * u[1])
        rows = [[2.0, *spot, (240.0 if middle else 80.0) * x, 2e4, mu, *eye, 0.85 * np.hypot(eye[0] - x0, eye[1]), 0.0, 0.0]]
    elif shape == "hose":
        half, pull = (0.06, 60.0) if middle else (0.1, 12.0)
        rows = [[3.0, *spot, pull * x, 2e4, mu, x0 - half, x0 + half, side * 0.3 * reach, side, 10.0]]
    else:  # a post, felt at two Gauss points of each edge
        r = 0.03 + 0.01 * u[0]
        rows = [[1.0, e, w, 1e7 * rod.h, 1e6 * rod.h, mu, x0, side * (r + (1.0 - x) * reach), r, 0.0, 0.0]
                for e in range(3 * n // 8, 11 * n // 16) for w in (0.211325, 0.788675)]
    return {"points": np.vstack([rod.points, rows]), "form": shape, "friction": mu, "stiffness": rows[0][3], "geometry": rows[0][6:]}


def apply(arm: Arm, name: str, x: float, rng: np.random.Generator, paths: Array) -> dict[str, Any]:
    """Put a law of strength x (0 to 1) into the arm and return its parameters; `paths` are node positions without it."""
    rod, n, form, side, u = arm.rod, arm.rod.k.size, int(rng.integers(12)), float(rng.choice((-1.0, 1.0))), rng.uniform(0.0, 1.0, 3)
    s, a, markers = np.where(np.arange(n) == 0, 0.25, np.arange(n)) / n, x * side, np.arange(arm.place.size)
    mu, ones, lags = (0.3 + 0.3 * u[2]) * (form // 6), np.ones(n), (0.6 * x, 0.12 * x)[::int(side)]
    spot, reach, share = (0.2 + 0.6 * u[0], 0.06 + 0.08 * u[1]), 0.02 + 0.03 * u[0], np.arange(1, 6) / 15.0
    times = np.array(([0.3], [0.06, 0.6, 6.0])[form % 2]) * (1.0 + 3.0 * u[0])  # one branch (Zener), or a rough power law

    def pick(*options: Any) -> Any:
        return options[form % len(options)]

    def even(shape: Array) -> Array:
        return shape / np.average(shape, weights=1.0 / rod.per)

    options: dict[str, Callable[[], dict[str, Any]]] = {
        "stiffness_gradient": lambda: {"form": pick("linear", "fourth power of a tapering diameter"), "slope": a, "k": rod.k * even(
            pick(1.0 + 0.9 * a * (1.0 - 2.0 * s), (1.0 - 0.7 * x * (s if side > 0 else 1.0 - s)) ** 4))},
        "soft_spot": lambda: {"k": rod.k * (1.0 + 9.0 * x) ** (-side * np.exp(-(((s - spot[0]) / spot[1]) ** 4))),
                              "centre": spot[0], "half_width": spot[1], "factor": (1.0 + 9.0 * x) ** -side},
        "preset_bend": lambda: {"rest": rod.rest + 0.6 * a * pick(ones, 2.0 * (s < 0.5), 2.0 * (s >= 0.5)),
                                "form": pick("uniform", "upper half", "lower half"), "bend_rad": 0.6 * a},
        "stiffening": lambda: {pick("hard", "soft"): 8.0 * x, "form": pick("cubic", "softening"), "strength": 8.0 * x},
        "bending_stop": lambda: {"stop": 1.2 - x, "limit_rad": 1.2 - x},
        "backlash": lambda: {"play": 0.6 * x, "play_rad": 0.6 * x},
        "dry_friction": lambda: {"jenkins": np.vstack([rod.jenkins, [0.5 * x / reach, 0.5 * x]]),  # Prandtl
                                 "moment_Nm": 0.5 * x, "slip_bending_rad": reach},
        "hysteresis": lambda: {"jenkins": np.vstack([rod.jenkins, x * np.column_stack([1.0 / (45.0 * reach) + 0.0 * share, share])]),
                               "moment_Nm": x, "slip_bending_rad": 45.0 * share * reach},  # Iwan 1966
        "viscoelastic": lambda: {"times_s": times, "share_each": 1.5 * x / times.size, "maxwell": np.vstack(
            [rod.maxwell, np.column_stack([0.0 * times + 1.5 * x / times.size, times])])},
        "quadratic_damping": lambda: {**pick({"quad": 0.5 * x}, {"drag": rod.drag + 300.0 * x * rod.h}),
                                      "form": pick("bending", "medium"), "coefficient": pick(0.5, 300.0) * x},
        "damping_gradient": lambda: {"c": rod.c * even(np.exp(8.0 * a * (0.5 - s))), "exponent": -8.0 * a},
        "actuator_lag": lambda: {"act": lambda tau, dt: follow(tau, dt, 0.5 * x, 0.5 * x, 1e9), "lag_s": 0.5 * x},
        "unequal_lag": lambda: {"act": lambda tau, dt: follow(np.maximum(tau, 0.0), dt, *lags, 1e9)  # two chambers
                                - follow(np.maximum(-tau, 0.0), dt, *lags, 1e9), "fill_s": lags[0], "vent_s": lags[1]},
        "dead_time": lambda: {"act": lambda tau, dt: np.interp(np.arange(tau.size) - 0.3 * x / dt, np.arange(tau.size), tau),
                              "delay_s": 0.3 * x},
        "slew_limit": lambda: {"act": lambda tau, dt: follow(tau, dt, 1e-3, 1e-3, 0.5 / x), "rate_Nm_per_s": 0.5 / x},
        "torque_bias": lambda: {"act": lambda tau, dt: tau + 0.4 * a, "bias_Nm": 0.4 * a},
        "torque_map": lambda: {"form": pick("saturating", "dead band", "unequal sides"), "strength": a, "act": lambda tau, dt: pick(
            np.tanh(6.0 * x * tau) / (6.0 * x), tau - np.clip(tau, -0.6 * x, 0.6 * x), tau * (1.0 + 0.9 * a * np.sign(tau)))},
        "torque_decay": lambda: {"drive": rod.drive * pick(np.exp(-6.0 * x * s), 1.0 - x * s), "form": pick("capstan", "linear"),
                                 "strength": x},
        "gravity_tilt": lambda: {**pick({"gravity": rod.gravity[0] * np.array([np.cos(a), np.sin(a)])}, {"clamp": a}),
                                 "form": pick("cameras true to the mount", "cameras true to the plumb line"), "tilt_rad": a},
        "tip_mass": lambda: {"mass": rod.mass + 0.3 * x * (np.arange(n + 1) == n), "mass_kg": 0.3 * x},
        "added_mass": lambda: {"mass": rod.mass * (1.0 + 0.5 * x / MASS), "mass_kg": 0.5 * x},
        "marker_offset": lambda: {"offset": arm.offset + 0.03 * a * pick(markers >= 0, markers == markers[-1]),
                                  "form": pick("all", "tip"), "offset_m": 0.03 * a},
        "marker_slip": lambda: {"place": arm.place - 0.06 * x / LENGTH * (markers == pick(*markers)), "marker": pick(*markers),
                                "slip_m": -0.06 * x},
        "stress_softening": lambda: {"mullins": 0.9 * x, "lost_share": 0.9 * x},
        "restraint": lambda: contact(rod, False, pick("wall", "band", "hose"), x, side, mu, u, paths),
        "band_midway": lambda: contact(rod, True, pick("band", "hose"), x, side, mu, u, paths),
        "post_midway": lambda: contact(rod, True, "post", x, side, mu, u, paths),
        "floor_under_tip": lambda: contact(rod, False, "floor", x, side, mu, u, paths),
    }
    new = options[name]()
    arm.rod, arm.act = rod._replace(**{key: new.pop(key) for key in Rod._fields if key in new}), arm.act + [new.pop("act", None)]
    arm.place, arm.offset = new.pop("place", arm.place), new.pop("offset", arm.offset)
    return {key: np.array(value).tolist() for key, value in new.items()}


class Case:
    """One arm with its cameras and its program of trials; everything follows from the seed."""

    def __init__(self, seed: int) -> None:
        rng = self.rng = np.random.default_rng(seed)
        self.seed, self.down, self.rate = seed, float(rng.choice((-1.0, 1.0))), int(rng.integers(50, 121))
        self.factors, self.noise = rng.uniform((0.85, 0.6), (1.15, 1.4)), float(rng.uniform(0.15, 0.6))  # -, mm
        self.arcs = np.append(np.round(np.sort(rng.uniform(0.06, 0.2, int(rng.integers(1, 4)))), 3), LENGTH)
        self.slope, self.slip = float(rng.uniform(-0.01, 0.01)), rng.normal(0.0, 5e-5, self.arcs.size)  # two small nuisances
        levels = np.round(rng.uniform((1.0, 0.03), (2.0, 0.08), (int(rng.integers(1, 3)), 2)), 3)
        pool = ("steps", "staircase", "sine", "chirp", "release", "held release")
        names = ["steps", pool[rng.integers(2, 4)], "staircase", *rng.choice(pool, int(rng.integers(2, 6)))]
        self.trials = [self.trial(str(name), *levels[i % len(levels)]) for i, name in enumerate(names)]

    def trial(self, name: str, keq: float, damping: float) -> Trial:
        """Draw one trial of a program."""
        rng, free = self.rng, name.endswith("release")
        last, top = float(rng.uniform(2.0, 3.0 if free else 6.0)), min(1.0, float(rng.uniform(0.6, 0.95)) * keq) * (not free)
        t, signs = np.arange(int(last * self.rate)) / self.rate, (-1.0) ** (np.arange(20) + rng.integers(2))
        levels, wait, f = rng.uniform(0.3, 1.0, 20) * signs, rng.uniform(0.5, 1.0), rng.uniform(0.3, 1.5)
        tau = {"steps": np.where(t < 0.2, 0.0, levels[((t - 0.2) / wait).astype(int)]),
               "staircase": np.round(3.0 * np.arcsin(np.sin(2.0 * np.pi * t / last)) * 2.0 / np.pi) / 3.0 * signs[0],
               "chirp": np.sin(2.0 * np.pi * (0.2 * t + f * t**2 / last))}.get(name, np.sin(2.0 * np.pi * f * t))
        pull = 3.0 * keq / LENGTH**2 * float(rng.uniform(0.05, 0.1)) * signs[0] * free
        start = int(rng.uniform(0.2, 0.5) * self.rate) if name == "held release" else 0
        return Trial(name, float(keq), float(damping), t, np.round(top * tau, 6), float(pull), start)

    def show(self, laws: list[tuple[str, float, Array]], mesh: tuple[int, float], factors: Array,
             poses: Sequence[Array | None] = (None,) * 8) -> tuple[Array, list[Array], list[Array], list[Array], list[dict]]:
        """Play all trials of the arm with laws (name, strength, free paths) and factors of keq and damping.

        Return all marker positions from the releases on, stacked (rows, 2); for each trial the node positions, the marker
        positions and the pose at the start; last, the parameters of the laws.
        """
        n, ones = mesh[0], np.ones(mesh[0])
        mass, empty = MASS / n * (1.0 + self.slope * (np.arange(n + 1) / n - 0.5)) * np.append(ones, 0.5), np.zeros((0, 2))
        rod = Rod(n * (1.0 + (np.arange(n) == 0)), factors[0] * ones, factors[1] * ones, 0.0 * ones, ones, mass,
                  np.array([self.down * GRAVITY, 0.0]), empty, empty, np.zeros((0, 11)), LENGTH / n, 0.026 * LENGTH / n)
        arm = Arm(rod, [], (self.arcs + self.slip) / LENGTH, np.zeros(self.arcs.size))
        told = [apply(arm, name, x, np.random.default_rng([self.seed, zlib.crc32(name.encode())]), paths) for name, x, paths in laws]
        nodes, seen, start = zip(*[arm.play(trial, mesh[1], pose) for trial, pose in zip(self.trials, poses)])
        stacked = np.concatenate([view[trial.start:].reshape(-1, 2) for trial, view in zip(self.trials, seen)])
        return stacked, nodes, seen, start, told

    def add(self, laws: list[tuple[str, float, Array]], name: str, target: float) -> float:
        """Append a law that opens a gap of `target` mm on top of `laws`. Return the gap on the fine mesh."""
        seen, nodes, *_ = self.show(laws, COARSE, self.factors)
        slopes = np.column_stack([(self.show(laws, COARSE, self.factors * np.exp(d))[0] - seen).ravel() / d.sum()
                                  for d in np.diag((0.03, 0.06))])
        logs, paths, low, high, x = np.zeros(2), np.concatenate(nodes), (0.0, 0.0), (1.0, np.inf), 0.1

        def gap(mesh: tuple[int, float]) -> float:
            """Return the RMS marker distance [mm] to the best arm without the law (Gauss-Newton, Broyden's slopes)."""
            seen, _, _, poses, _ = self.show([*laws, (name, x, paths)], mesh, self.factors)
            for trip in range(5):
                rest = (seen - self.show(laws, mesh, self.factors * np.exp(logs), poses)[0]).ravel()
                if trip:
                    slopes[:] += np.outer(before - rest - slopes @ move, move) / (move @ move)
                left = rest - slopes @ (move := np.linalg.lstsq(slopes, rest, rcond=None)[0])
                if np.max(np.abs(move)) < 0.02:
                    break
                before, move = rest, np.clip(logs + move, -1.6, 1.6) - logs
                logs[:] += move
            return 1e3 * float(np.sqrt(left @ left / len(seen)))

        for _ in range(16):
            try:
                wide = gap(COARSE)
            except ValueError:
                wide = np.inf
            if abs(wide / target - 1.0) < 0.05:
                break
            low, high = ((x, wide), high) if wide < target else (low, (x, wide))
            if low[0] > 0.999 or high[0] < 1e-4:
                raise ValueError(f"{name} does not reach {target:.1f} mm on this arm")
            part = (target - low[1]) / (high[1] - low[1]) if high[1] < np.inf else 0.5
            x = low[0] + (high[0] - low[0]) * float(np.clip(part, 0.1, 0.9)) if high[0] < 1.0 else min(1.0, 3.0 * x)
        wide = gap(FINE)
        laws.append((name, x, paths))
        return wide


def record(folder: Path, seed: int, laws: Sequence[tuple[str, str]], *, smooth: bool = False) -> dict[str, Any]:
    """Write one dataset and return the truth. Raises ValueError where a law cannot reach its size on this arm."""
    case, chosen, folder = Case(seed), [], Path(folder)
    gaps = [case.add(chosen, name, min(FLOORS[size] * np.sqrt(2.0) * case.noise, CAP)) for name, size in laws]
    _, _, views, _, told = case.show(chosen, FINE, case.factors)
    names = [f"m{i + 1}" for i in range(case.arcs.size - 1)] + ["tip"]
    text = [f'format = 1\nname = "{folder.name}"\n\n[robot]\nlength = {LENGTH}\nmass = {MASS}\ndiameter = {DIAMETER}\n'
            f'mount = "{"hanging" if case.down > 0 else "upright"}"']
    text += [f'\n[[marker]]\nname = "{name}"\narc_length = {arc:.3f}' for name, arc in zip(names, case.arcs)]
    folder.mkdir(parents=True, exist_ok=True)
    for i, (trial, view) in enumerate(zip(case.trials, views), 1):
        seen = np.stack([view[..., 1], 0.002 * view[..., 1], -case.down * view[..., 0]], 2)  # a third nuisance: the plane is askew
        seen += case.rng.normal(0.0, 1e-3 * case.noise, seen.shape)
        if smooth:
            seen = (savgol_filter(seen, 2 * int(0.07 * case.rate) + 1, 3, axis=0) if seed % 2
                    else sosfiltfilt(butter(2, 8.0, fs=case.rate, output="sos"), seen, axis=0))
        driven = trial.program != "release"
        table = np.column_stack([trial.t] + [trial.tau] * driven + [seen.reshape(trial.t.size, -1)])
        header = ",".join(["t"] + ["tau"] * driven + [f"{name}_{axis}" for name in names for axis in "xyz"])
        np.savetxt(folder / f"trial_{i:02d}.csv", table, "%.6f", ",", header=header, comments="")
        text.append(f'\n[[trial]]\nfile = "trial_{i:02d}.csv"\nkeq = {trial.keq}\ndamping = {trial.damping}')
        text += [f"t_start = {trial.t[trial.start]:.6f}"] * (trial.start > 0)
    (folder / "dataset.toml").write_text("\n".join(text) + "\n")
    return {"laws": [{"name": law[0], "parameters": p, "gap_mm": gap} for law, p, gap in zip(chosen, told, gaps)],
            "keq_factor": float(case.factors[0]), "damping_factor": float(case.factors[1]), "noise_mm": case.noise, "smooth": smooth}
