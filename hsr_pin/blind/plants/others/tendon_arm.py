"""A planar tendon arm: a compliant backbone with spacer discs, two antagonistic tendons, two winches with a tension servo.

Mechanics.  The backbone is inextensible and its angle is linear in arc length within a segment.  The coordinates are the angles at
the segment ends (the first is the base, on a very stiff spring unless a law frees it) and the wound length of each tendon.
Lagrange's equations: with two Gauss points a segment, the kinetic energy is a constant matrix times cosines of angle differences.  A
tendon runs straight from disc to disc, so over a gap it shortens by radius * bend and, to leading order, gap * bend^2 / 24; tension
times the derivative of the length loads every segment (Camarillo et al. 2008, Rucker and Webster 2011).  A winch obeys rotor * x'' +
drag * x' = asked tension - tension; a tendon is a one-sided spring.  A commanded torque is asked as pretension +-
torque / (2 radius).  Steps are BDF2 with Newton iterations; long Euler steps settle the arm before a trial.

Nuisances of every arm: the chord term, winches that resist back-driving and follow within about a millisecond, discs with lumped mass
and rotary inertia, a preset bend below half a milliradian.  A command jumps at the instant of the first row that shows the new value
(JUMP_EARLY moves it); sines are continuous.  Each law is sized alone, against the refitted arm without any law.
`python tendon_arm.py` checks the plant against theory and finer steps and prints the figures."""
from __future__ import annotations

import copy
import math
import tempfile
import time
import zlib
from collections import namedtuple
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numba import njit
from scipy import signal

SIZES = {"barely": 2.0, "medium": 6.0, "large": 15.0}      # noise floors
CAP = 0.012                                               # m, the largest size
LENGTH, MASS, DIAMETER, GRAVITY = 0.24, 0.15, 0.04, 9.81  # m, kg, m, m/s^2
DISCS, DISC_SHARE, RADIUS, PRETENSION = 12, 0.6, 0.016, 42.0  # -, of the mass, m (routing), N
STEP, SIZE_STEP, SETTLE_STEP, SETTLE_COUNT = 1.0e-3, 2.0e-3, 0.01, 400  # s, s (while a law is sized), s, -
JUMP_EARLY = 0.0                                          # samples by which a jump precedes the first row that shows it
XI = np.array([0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)])  # Gauss points of a unit segment
# What the stepper gets: Plant's fields of the same names, and the geometry that `_arm` builds from them.
Arm = namedtuple("Arm", "n h inertia first tip lumps at nodes bends k c preset play low high stiff rub give shape branch relax "
                 "quad a chord winch capstan cog gx ga base side")

class Plant(SimpleNamespace):
    """One arm, its drive and its cameras, in SI units.  Arrays over the segments: k and c (profiles of stiffness, with mean compliance
    1, and of damping, with mean 1), preset (rad), play (half width of a dead zone, rad), low and high (stops, rad), a (routing radius).
    Hysteretic elements (segment, element): rub (Nm), tied (the same relative to the segment's stiffness, rad), give (bend scale, rad),
    shape (per element, 0 exponential, 1 spring and slider).  Maxwell branches: branch (stiffness relative to the backbone), relax (s).
    stiff: (b, w) of the moment k e (1 + b (e / 0.6 rad of the whole arm)^2)^w.  quad: Nm (s/rad)^w of the whole arm, and w.  winch:
    N/m of the tendon, reflected rotor in kg, N s/m while taut and while slack, slack in m that is paid out at most.
    capstan: friction, wrap at rest per disc in rad, sliding in m until it is full.  cog: N of ripple, m of tendon per radian of it.
    base: inertia, damping, stiffness and rest angle of its rocking.  side: constant force across the tip, stiffness, place and sense (0
    is both) of a restraint.  filters: numerators and denominators in s that the asked tension passes.  uneven: lags (s) of a rising and
    a falling tension.  warp: torque of the command.  gain: of the place in the session, 0 to 1.  markers and offset: true places along
    the arm and off the neutral line (m).  tilt: of gravity in the base's frame (rad).  delay (s), bias (Nm), scale (of the cameras)."""

def _plant(rng: np.random.Generator, n: int = DISCS) -> Plant:
    """An arm with nothing missing but its nuisances; one to three markers stand below the tip."""
    zero, below = np.zeros(n), int(rng.integers(1, 4))
    inner = np.round(LENGTH * (np.arange(below) + 1 + rng.uniform(-0.2, 0.2, below)) / (below + 1), 3)
    return Plant(
        n=n, upright=bool(rng.random() < 0.5), k=zero + 1, c=zero + 1, preset=zero + rng.uniform(-5e-4, 5e-4) / n, play=zero, low=zero - 9,
        high=zero + 9, a=zero + RADIUS, rub=np.zeros((n, 5)), tied=np.zeros((n, 5)), give=np.ones((n, 5)), shape=(0, 0, 0, 0, 0),
        branch=(0.0,), relax=(1.0,), stiff=(0.0, 1.0), quad=(0.0, 2.0), winch=(1e4, 0.002, 3.0, 3.0, 0.002), capstan=(0.0, 0.0, 5e-5),
        cog=(0.0, 1.0), base=(1e-3, 0.0, 1e6, 0.0), side=(0.0, 0.0, 0.0, 0.0), length=LENGTH, mass=MASS, tip_mass=0.0, tilt=0.0,
        pretension=PRETENSION, delay=0.0, filters=(), uneven=(), bias=0.0, warp=None, gain=None, scale=1.0,
        markers=np.append(inner, LENGTH), offset=np.zeros(below + 1))

class Trial(SimpleNamespace):
    """One trial: kind, t (s), tau (the commanded torque as a function of time, constant before t = 0), the declared keq and damping,
    hold (from outside until the row `release`: N across at the tip, Nm everywhere)."""

def _levers(n: int, length: float, s: np.ndarray) -> np.ndarray:
    """Weights that integrate a function, given at the Gauss points, from the base to each s (linear inside a segment)."""
    x = np.clip(np.asarray(s)[:, None] * n / length - np.arange(n), 0.0, 1.0)
    return np.stack([XI[1] * x - x * x / 2, x * x / 2 - XI[0] * x], axis=2).reshape(len(x), 2 * n) * length / n / (XI[1] - XI[0])

def _arm(p: Plant, keq: float, damping: float) -> Arm:
    """The stepper's view of the plant at one true stiffness and damping of the whole arm."""
    n, h, k = p.n, p.length / p.n, p.n * keq * p.k
    s = np.concatenate([(np.arange(240) + 0.5) / 240, np.arange(DISCS + 1) / DISCS, [1.0]]) * p.length
    disc = np.r_[0.5, np.ones(DISCS - 1), 0.5] / DISCS
    m = np.concatenate([np.full(240, (1 - DISC_SHARE) * p.mass / 240), DISC_SHARE * p.mass * disc, [p.tip_mass]])
    here, following, lever = np.eye(n, n + 3), np.eye(n, n + 3, 1), _levers(n, p.length, s)
    at = np.kron(here, 1 - XI[:, None]) + np.kron(following, XI[:, None])
    lumps = np.r_[p.base[0], np.full(n, p.mass * (DIAMETER / 2) ** 2 / 4 / n), p.winch[1], p.winch[1]]
    own = dict(h=h, inertia=lever.T @ (m[:, None] * lever), first=m @ lever, tip=lever[-1].copy(), lumps=lumps, at=at,
               nodes=at.T.copy(), bends=following - here, k=k, c=n * damping * p.c, rub=p.rub + p.tied * k[:, None],
               chord=p.length / DISCS * n / DISCS, gx=GRAVITY * math.sin(p.tilt), ga=GRAVITY * math.cos(p.tilt) * (1 - 2 * p.upright))
    own |= {name: np.array(getattr(p, name), float) for name in ("shape", "branch", "relax")}
    got = vars(p) | own
    return Arm(**{name: tuple(map(float, got[name])) if isinstance(got[name], tuple) else got[name] for name in Arm._fields})

@njit(cache=True)
def _residual(p, y, v, acc, y1, sig1, mx1, cap1, ask, hold, ex, fac, a0, live, slope, sig, mx, cap):
    """Unbalanced generalised loads, and sines and cosines at the Gauss points; writes tangents (segments, winches, tendons) and the
    new memory of the segments.  `live` is 0 while the arm settles."""
    n = p.n
    th, om, al = p.at @ y, p.at @ v, p.at @ acc
    s, c = np.sin(th), np.cos(th)
    into = np.sum(p.tip * s) - p.side[2]
    force = p.side[0] + hold[0] - (p.side[1] * into if p.side[3] == 0.0 or into * p.side[3] > 0.0 else 0.0)
    tq = c * (p.inertia @ (c * al - s * om * om) - p.first * p.gx - p.tip * force)
    tq += s * (p.inertia @ (s * al + c * om * om) + p.first * p.ga)
    bend, rate, gone = p.bends @ y, p.bends @ v, p.bends @ (y - y1)
    e = bend - p.preset
    k, e = np.where(np.abs(e) > p.play, p.k, 0.0), np.sign(e) * np.maximum(0.0, np.abs(e) - p.play)
    r = p.stiff[0] * (e * n / 0.6) ** 2
    f, thick = (1.0 + r) ** p.stiff[1], live * p.quad[0] * n * np.abs(n * rate) ** (p.quad[1] - 1.0)
    over = np.maximum(0.0, bend - p.high) + np.minimum(0.0, bend - p.low)
    m = k * e * f + 30.0 * p.k * over + (p.c + thick) * rate - hold[1]
    slope[:n] = k * f * (1.0 + 2.0 * p.stiff[1] * r / (1.0 + r)) + 30.0 * p.k * (over != 0.0) + a0 * (p.c + p.quad[1] * thick)
    for q in range(p.shape.size):
        # Dahl 1968 (Bouc-Wen with n = 1 and beta = gamma is the same law), or Jenkins' element, of which Iwan 1966 puts several in a row
        raw = sig1[:, q] + gone / p.give[:, q]
        turn = np.where(gone >= 0.0, 1.0, -1.0)
        far = (turn - sig1[:, q]) * np.exp(-np.abs(gone / p.give[:, q]))
        sig[:, q] = np.minimum(1.0, np.maximum(-1.0, raw)) if p.shape[q] > 0.0 else turn - far
        m += p.rub[:, q] * sig[:, q]
        slope[:n] += p.rub[:, q] / p.give[:, q] * (1.0 * (np.abs(raw) < 1.0) if p.shape[q] > 0.0 else np.abs(far))
    for q in range(p.branch.size):
        mx[:, q] = ex[q] * mx1[:, q] + p.k * p.branch[q] * fac[q] * gone
        m += mx[:, q]
        slope[:n] += p.k * p.branch[q] * fac[q]
    kt, _, taut, loose, slack = p.winch
    drive, ratio, tied = np.zeros(2), np.ones(n), np.zeros((n, n))
    for j in range(2):
        arm = (1.0 - 2.0 * j) * p.a                        # tendon taken in per radian of each segment
        wound = y[n + 1 + j] - np.sum(arm * bend + p.chord * bend * bend / 24.0)
        turn = y[n + 1 + j] / p.cog[1] + 0.7 + 2.0 * j
        if p.capstan[0] > 0.0:                             # Euler and Eytelwein at every disc, a Dahl state for the sense of sliding
            slid, r, f = np.sum(arm * gone), 1.0, np.zeros(n)
            for i in range(n):
                d = 1.0 if slid >= 0.0 else -1.0
                wrap, cap[j, i] = p.capstan[0] * (p.capstan[1] + abs(bend[i] + (bend[i - 1] if i > 0 else 0.0)) / 2.0), d
                cap[j, i] -= (d - cap1[j, i]) * math.exp(-abs(slid) / p.capstan[2])
                f[i:] += wrap * abs(d - cap[j, i]) / p.capstan[2]
                r *= math.exp(-wrap * cap[j, i])
                ratio[i] = r
                slid -= arm[i] * gone[i]
            for i in range(n):
                tied[i] += ask[j] * ratio[i] * arm[i] * arm * np.minimum(f, f[i])
        pull = kt * max(0.0, wound) / np.mean(ratio)
        m -= pull * ratio * (arm + p.chord * bend / 12.0)
        drag = taut + (loose - taut) * min(1.0, max(0.0, -wound / 5e-4))  # half a millimetre of slack frees the winch
        drive[j] = drag * v[n + 1 + j] + pull - ask[j] + kt * min(0.0, wound + slack) - p.cog[0] * math.sin(turn)
        slope[n + j] = a0 * drag - p.cog[0] / p.cog[1] * math.cos(turn)
        slope[n + 2 + j] = kt if wound > 0.0 or wound < -slack else 0.0
    res = p.nodes @ tq + m @ p.bends + p.lumps * acc
    res[0] += p.base[1] * v[0] + p.base[2] * (y[0] - p.base[3])
    res[n + 1:] += drive
    return res, s, c, tied

@njit(cache=True)
def _inverse(p, a0, slope, s, c, tied):
    """Inverse of the tangent without gravity, contact, capstan and drag, which the iterations make up for."""
    n, mat = p.n, p.nodes @ (a0 * a0 * p.inertia * (np.outer(s, s) + np.outer(c, c))) @ p.at
    mat += p.bends.T @ ((np.diag(slope[:p.n]) + tied) @ p.bends) + np.diag(a0 * a0 * p.lumps)
    mat[0, 0] += a0 * p.base[1] + p.base[2]
    for j in range(2):
        row = (2.0 * j - 1.0) * (p.a @ p.bends)
        row[n + 1 + j] = 1.0
        mat += slope[n + 2 + j] * np.outer(row, row)
        mat[n + 1 + j, n + 1 + j] += slope[n + j]
    return np.ascontiguousarray(np.linalg.inv(mat))

@njit(cache=True)
def _run(p, ask, hold, step, every, settle_step, settle_count):
    """Settles under the first row of `ask` (N, two tendons) and `hold` (N at the tip, Nm everywhere), then steps through the rest.
    Returns the coordinates at every `every`-th instant; rows are nan from where the iterations fail."""
    n, rows = p.n, ask.shape[0]
    out, y1, v1, slope = np.full(((rows - 1) // every + 1, n + 3), np.nan), np.zeros(n + 3), np.zeros(n + 3), np.zeros(n + 4)
    y1[:n + 1], y1[n + 1:] = p.base[3], ask[0] / p.winch[0]
    y2, v2, v, acc, inverse = y1.copy(), v1.copy(), v1.copy(), v1.copy(), np.zeros((n + 3, n + 3))
    sig1, mx1, cap1, ex, fac = np.zeros(p.rub.shape), np.zeros((n, p.branch.size)), np.zeros((2, n)), 0.0 * p.branch, 0.0 * p.branch
    sig, mx, cap = sig1.copy(), mx1.copy(), cap1.copy()
    for now in range(-settle_count, rows):
        if now == 0:                                       # the settled state is the first sample; everything is at rest
            v1[:], y2[:], v2[:], out[0] = 0.0, y1, 0.0, y1
            continue
        dt, row, live = (settle_step, 0, 0.0) if now < 0 else (step, now, 1.0)
        a0, a1, a2 = (1.0 / dt, -1.0 / dt, 0.0) if now < 2 else (1.5 / dt, -2.0 / dt, 0.5 / dt)
        if now > 0:                                        # before, the Maxwell branches are relaxed
            ex = np.exp(-dt / p.relax)
            fac = p.relax / dt * (1.0 - ex)
        y, big = y1 + live * dt * v1, 1.0
        for it in range(60):
            v[:] = a0 * y + a1 * y1 + a2 * y2
            acc[:] = a0 * v + a1 * v1 + a2 * v2
            res, s, c, tied = _residual(p, y, v, acc, y1, sig1, mx1, cap1, ask[row], hold[row], ex, fac, a0, live, slope, sig, mx, cap)
            if it == 0 or big > 1e-4 or it > 5:
                inverse[:] = _inverse(p, a0, slope, s, c, tied)
            change = inverse @ res
            big = np.max(np.abs(change))
            y -= change * (1.0 if it < 20 else 0.5)
            if big < 1.0e-8 or not big < 1.0e3:
                break
        if not big < (1.0e-5 if now > 0 else 1.0e3):
            return out
        v[:] = a0 * y + a1 * y1 + a2 * y2
        y2[:], v2[:] = y1, v1
        y1[:], v1[:], sig1[:], mx1[:], cap1[:] = y, v, sig, mx, cap
        if now > 0 and now % every == 0:
            out[now // every] = y1
    return out

def _asked(p: Plant, trial: Trial, t: np.ndarray, place: float) -> np.ndarray:
    """Tensions asked of the two winches at the stepper's instants (N)."""
    tau = (trial.tau(t - p.delay - 1e-7) + trial.tau(t - p.delay + 1e-7)) / 2  # a jump counts half at its own instant
    tau = (p.warp(tau) if p.warp else tau) * (p.gain(place) if p.gain else 1.0) + p.bias
    pulls = [np.maximum(0, tau) * 2, np.maximum(0, -tau) * 2] if p.uneven else [tau, -tau]  # uneven: only the pulling winch acts
    ask, dt = p.pretension + np.stack(pulls, axis=1) / (2 * RADIUS), t[1] - t[0]
    for top, bottom in p.filters:
        ask = ask[0] + signal.lfilter(*signal.bilinear(top, bottom, 1 / dt), ask - ask[0], axis=0)
    for row in range(1, len(t) * bool(p.uneven)):
        gone = ask[row] - ask[row - 1]
        ask[row] = ask[row - 1] + gone * np.where(gone > 0, *(1 - np.exp(-dt / np.array(p.uneven))))
    return ask

def _tracks(p: Plant, trials: Sequence[Trial], factors: tuple[float, float], step: float = STEP) -> list[np.ndarray]:
    """Places of the markers (row, marker, x and z) in every trial, without noise, at factors of declared stiffness and damping."""
    tracks = []
    for index, trial in enumerate(trials):
        arm, pause = _arm(p, trial.keq * factors[0], trial.damping * factors[1]), trial.t[1] - trial.t[0]
        every = math.ceil(pause / step - 1e-6)
        t = np.arange((len(trial.t) - 1) * every + 1) * pause / every
        hold = np.outer(np.arange(len(t)) <= trial.release * every, trial.hold)
        hold[trial.release * every] *= 0.5 if trial.release else 1.0
        y = _run(arm, _asked(p, trial, t, index / (len(trials) - 1)), hold, t[1], every, SETTLE_STEP, SETTLE_COUNT)
        if not np.isfinite(y).all():
            raise ValueError("the arm does not settle or collapses")
        lever, theta = _levers(p.n, p.length, p.markers).T, y @ arm.at.T
        section = y[:, :p.n + 1] @ np.maximum(0, 1 - abs(p.markers / arm.h - np.arange(p.n + 1)[:, None]))
        x, along = np.sin(theta) @ lever + p.offset * np.cos(section), np.cos(theta) @ lever - p.offset * np.sin(section)
        tracks.append(p.scale * np.stack([x, along if p.upright else -along], axis=2))
    return tracks

def _program(rng: np.random.Generator) -> list[Trial]:
    """Five to eight trials at one or two declared stiffness levels."""
    rate, count, trials, damping = float(rng.choice([50, 60, 64, 75, 90, 100, 120])), int(rng.integers(5, 9)), [], rng.uniform(0.03, 0.08)
    levels = np.clip(rng.uniform(1.0, 2.0) * np.array([1.0, rng.choice([1.0, rng.uniform(0.75, 1.3)])]), 1.0, 2.0)
    kinds = ["steps", "staircase", "steps", str(rng.choice(["sine", "chirp"])), str(rng.choice(["release", "held"]))]
    kinds += list(rng.choice(["steps", "staircase", "sine", "chirp", "release", "held"], count - 5))
    for place, kind in enumerate(rng.permutation(kinds)):
        keq, sign, start = round(float(levels[place % 2]), 3), float(rng.choice([-1, 1])), rng.uniform(0.2, 0.5)
        top, first, steps = sign * min(0.95, 0.75 * keq) * rng.uniform(0.6, 1.0), 0.0, int(rng.integers(2, 4))
        last = rng.uniform(*{"release": (2.0, 3.0), "held": (3.0, 4.0), "steps": (2.8, 4.0)}.get(kind, (3.5, 6.0)))
        t, share = np.arange(int(last * rate) + 1) / rate, float(rng.choice([1.0, keq / levels[0]]))
        trial = Trial(kind=str(kind), t=t, tau=np.zeros_like, keq=keq, hold=(0.0, 0.0), release=0)
        trial.damping = round(min(0.08, max(0.03, damping * share)), 4)
        if kind in ("steps", "staircase", "held"):
            values = top * np.array([1.0, -rng.uniform(0.4, 1), rng.uniform(0.2, 0.8)][:steps] + [0.0])
            if kind == "staircase":
                values = top * np.r_[np.arange(1, steps + 1), np.arange(steps - 1, -2, -1)] / steps
            elif kind == "held":                           # released at rest, in half of the cases with steps after it
                trial.release, values = int(start * rate), values[:-1] * rng.choice([0.0, 1.0])
                start = t[trial.release] + rng.uniform(0.7, 1.0)
            else:
                first = -top * float(rng.choice([0.0, 0.0, 0.6]))
            rows = np.round((start + np.arange(len(values)) * (last - start) / len(values)) * rate)
            trial.tau = lambda x, at=(rows - JUMP_EARLY) / rate, v=np.append(first, values): v[np.searchsorted(at, x, side="right")]
        if kind in ("sine", "chirp"):                      # the chirp's frequency grows evenly
            f, up = (rng.uniform(0.3, 1.5), 0.0) if kind == "sine" else (0.2, rng.uniform(1.5, 3.0) / last)
            trial.tau = lambda x, a=top, s=start, f=f, up=up: a * np.sin(2 * np.pi * (f + up * (x - s) / 2) * np.maximum(0, x - s))
        if kind in ("release", "held"):                    # by a thread at the tip, or in a jig that bends the arm evenly
            push = sign * rng.uniform(0.4, 0.8) * keq
            trial.hold = (push / LENGTH, 0.0) if rng.random() < 0.5 else (0.0, push)
        trials.append(trial)
    return trials

class Draw(namedtuple("Draw", "x sign form r q u peak")):
    """What the seed draws for one law: strength, sense (+-1), form (0 to 5), two numbers from 0 to 1; then the places of the segments (0
    to 1) and the largest bend that the commands alone ask for (rad)."""

    def pick(self, *forms: object) -> object:
        """The one of the forms that was drawn."""
        return forms[self.form % len(forms)]

def _taper(p: Plant, d: Draw) -> dict:
    f = d.pick((1 + d.sign * d.x * (d.u - 0.5)) ** 4, np.exp(4 * d.sign * d.x * (d.u - 0.5)))
    return {"k": p.k * f * np.mean(1 / f)}

def _spot(p: Plant, d: Draw) -> dict:
    wide, off = 0.12 + 0.13 * d.r, abs(d.u - 0.15 - 0.7 * d.q)
    bump = d.pick(np.cos(np.minimum(off / wide, 1) * np.pi / 2) ** 2, np.clip((wide / 2 - off) * p.n + 0.5, 0, 1))
    return {"k": p.k * (1 + d.x * bump) ** (1 if d.form == 5 else -1)}

def _loops(p: Plant, d: Draw) -> dict:
    span = np.tile((0.1 + 0.2 * d.r) / p.n * np.array(d.pick([1.0, 1, 1, 1], [0.25, 0.5, 1, 2])), (p.n, 1))
    return {"k": p.k * (1 - d.x), "tied": np.c_[p.tied[:, :1], d.x / (1 - d.x) * span / 4], "give": np.c_[p.give[:, :1], span],
            "shape": p.shape[:1] + (d.form % 2,) * 4}

def _creep(p: Plant, d: Draw) -> dict:
    relax = d.pick((0.3 + d.r,), (0.05, 0.4, 3.0), (0.02, 0.09, 0.4, 1.8, 8.0))
    share = np.array(relax) ** d.pick(0.0, 0.0, -0.3)
    return {"relax": relax, "branch": tuple(d.x * share / share.sum())}

def _ring(p: Plant, d: Draw) -> dict:
    w, heavy = 2 * math.pi / d.x, p.winch[0] * (d.x / (2 * math.pi)) ** 2
    drag = 2 * (0.05 + 0.1 * d.r) * math.sqrt(p.winch[0] * heavy)
    return d.pick({"filters": p.filters + (([w * w], [1, 2 * (0.1 + 0.15 * d.r) * w, w * w]),)},
                  {"winch": (p.winch[0], heavy, drag, drag, p.winch[4])})

# Every law: the kinds that describe it, the strength where the search starts and the largest, what it changes in the plant.
LAWS: dict[str, tuple[str, float, float, Callable[[Plant, Draw], dict]]] = {
    "stiffness_gradient": ("elastic", 0.3, 1.8, _taper),   # a conical backbone, or an exponential taper
    "soft_spot": ("elastic", 0.2, 20, _spot),              # a smooth bump or a box; one in six is stiffer
    "preset_bend": ("elastic", 0.05, 1.5, lambda p, d: {   # even, growing to the tip, growing to the base
        "preset": p.preset + d.sign * d.x / p.n * d.pick(0 * d.u + 1, 2 * d.u, 2 - 2 * d.u)}),
    "stiffening": ("elastic", 0.3, 50, lambda p, d: {"stiff": (d.x, d.pick(1.0, 0.5, -0.25))}),  # cubic, to quadratic, softening
    "bending_stop": ("elastic contact", 0.2, 0.95, lambda p, d: {  # disc edges meet, on both sides or on one, at 30 times the stiffness
        "high": 0 * p.high + (9 if d.form % 2 and d.sign < 0 else d.peak * (1 - d.x) / p.n),
        "low": 0 * p.low - (9 if d.form % 2 and d.sign > 0 else d.peak * (1 - d.x) / p.n)}),
    "backlash": ("elastic friction", 0.03, 0.6, lambda p, d: {  # a dead zone at every disc or at one (Nordin and Gutman 2002)
        "play": d.x * d.pick(0 * d.u + 1 / p.n, (np.arange(p.n) == int(d.r * p.n)) / 3)}),
    "dry_friction": ("friction", 0.02, 0.6, lambda p, d: {  # Dahl or spring and slider, at every disc or at every second
        "rub": np.c_[d.x * d.pick(0 * d.u + 1, 0 * d.u + 1, np.arange(p.n) % 2), p.rub[:, 1:]],
        "give": np.c_[0 * d.u + 0.004 / p.n, p.give[:, 1:]], "shape": (d.form % 2,) + p.shape[1:]}),
    "hysteresis": ("friction", 0.2, 0.95, _loops),         # Bouc-Wen beside the backbone, or Iwan's four sliders
    "viscoelastic": ("creep", 0.1, 5, _creep),             # Zener, three decades of Maxwell branches, a spring-pot of exponent 0.3
    "quadratic_damping": ("damping", 0.01, 5, lambda p, d: {"quad": (d.x, d.pick(2.0, 3.0, 1.5))}),  # the rate to one of three powers
    "damping_gradient": ("damping", 0.5, 5, lambda p, d: {  # an exponential, or a step
        "c": p.c * (f := np.exp(2 * d.sign * d.x * d.pick(d.u, d.u < 0.3 + 0.4 * d.r))) / f.mean()}),
    "actuator_lag": ("actuation_time", 0.02, 1.5, lambda p, d: {  # one pole, or a second one four times faster
        "filters": p.filters + d.pick((([1], [d.x, 1]),), (([1], [0.8 * d.x, 1]), ([1], [0.2 * d.x, 1])))}),
    "unequal_lag": ("actuation_time", 0.02, 1, lambda p, d: {  # of rising and falling tension, and only the pulling winch is driven
        "uneven": (d.x, d.x / (2.5 + 2 * d.r))[::int(d.sign)]}),
    "dead_time": ("actuation_time", 0.02, 0.5, lambda p, d: {"delay": d.x}),
    "torque_bias": ("actuation_map", 0.03, 0.8, lambda p, d: {"bias": d.sign * d.x}),  # unequal pretension
    "torque_map": ("actuation_map", 0.2, 2, lambda p, d: {"warp": d.pick(  # an amplifier saturates, spools differ, a spool grows
        lambda v: np.tanh(2 * d.x * v) / (2 * d.x), lambda v: v + d.x * d.sign * abs(v) / 2, lambda v: v + d.x * d.sign * v * v / 2)}),
    "torque_decay": ("actuation_map", 0.1, 0.95, lambda p, d: {  # the tendons converge to the axis, or some strands end at one disc
        "a": p.a * (1 - d.x * d.pick(d.u, d.u > 0.3 + 0.4 * d.r))}),
    "gravity_tilt": ("mass_gravity measurement", 0.03, 0.7, lambda p, d: d.pick(  # of gravity, or of the base in the cameras' frame
        {"tilt": d.sign * d.x}, {"base": p.base[:3] + (d.sign * d.x,)})),
    "tip_mass": ("mass_gravity", 0.01, 0.5, lambda p, d: {"tip_mass": d.x}),
    "added_mass": ("mass_gravity", 0.03, 0.6, lambda p, d: {"mass": p.mass + d.x}),
    "restraint": ("contact", 0.1, 1.3, lambda p, d: {"side": d.pick(  # a spring, a wall on one side, a dead weight over a pulley
        (0, 60 * d.x, d.sign * 0.03 * d.r, 0), (0, 400, d.sign * 0.1 * (1 - d.x), d.sign), (d.sign * 2 * d.x, 0, 0, 0))}),
    "marker_offset": ("measurement", 0.003, 0.05, lambda p, d: {  # of the tip, or of all
        "offset": p.offset + d.sign * d.x * d.pick(p.markers == p.markers.max(), 1.0)}),
    "marker_slip": ("measurement", 0.003, 0.06, lambda p, d: {  # of one marker, the last one only towards the base
        "markers": p.markers + d.x * (np.arange(len(p.markers)) == int(d.r * len(p.markers)))
        * np.where(p.markers == p.markers.max(), -1, d.sign)}),
    "length_change": ("measurement", 0.02, 0.2, lambda p, d: {  # another backbone with the markers at their shares, or a slid clamp
        "length": p.length * (1 + d.sign * d.x), "markers": p.markers + d.sign * d.x * d.pick(p.markers, p.length)}),
    "camera_scale": ("measurement", 0.01, 0.15, lambda p, d: {"scale": 1 + d.sign * d.x}),
    # Not in the list, from here on.  The tendons rub on the discs.  A tension loop or a heavy rotor on its tendon rings (period x).
    "capstan_friction": ("friction actuation_map", 0.1, 3, lambda p, d: {"capstan": (d.x, 0.03 + 0.07 * d.r, 5e-5)}),
    "ringing_servo": ("actuation_time", 0.1, 0.6, _ring),
    # The mount rocks; the winches ride on it.
    "base_on_springs": ("mass_gravity elastic", 0.2, 3, lambda p, d: {
        "base": (0.002, (0.002 + 0.004 * d.r) / math.sqrt(d.x), 3 / d.x, p.base[3])}),
    # The torque per command changes over the trials, steadily or as a motor warms.  The torque ripples with the winch's angle.
    "gain_drift": ("actuation_map", 0.1, 0.9, lambda p, d: {"gain": d.pick(
        lambda s: 1 + d.sign * d.x * (2 * s - 1), lambda s: 1 - d.x * (1 - math.exp(-s / (0.2 + 0.3 * d.r))))}),
    "cogging": ("actuation_map elastic", 1, 15, lambda p, d: {"cog": (d.x, 0.0025 + 0.0015 * d.r)})}
CATALOGUE: dict[str, tuple[str, ...]] = {name: tuple(law[0].split()) for name, law in list(LAWS.items())[:-5]}
OUTSIDE: dict[str, tuple[str, ...]] = {name: tuple(law[0].split()) for name, law in list(LAWS.items())[-5:]}

def _apply(p: Plant, name: str, x: float, seed: int, peak: float) -> dict:
    """Puts a law of strength x into the plant and returns what was drawn and changed, where it is a short list of numbers."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    d = Draw(x, float(rng.choice([-1, 1])), int(rng.integers(6)), rng.random(), rng.random(), (np.arange(p.n) + 0.5) / p.n, peak)
    changes = LAWS[name][3](p, d)
    vars(p).update(changes)
    bulky = ("warp", "gain", "filters", "rub", "tied", "give")
    short = {key: np.round(value, 6).tolist() for key, value in changes.items() if key not in bulky}
    return {"strength": x, "form": d.form, "sign": d.sign, "r": d.r, "q": d.q} | short

def _strength(gap: Callable[[float], float], target: float, guess: float, most: float) -> tuple[float, float]:
    """Strength at which the gap meets the target within 5 % (15 % after twelve tries), and the gap there."""
    points, x = {0.0: 0.0}, guess
    for attempt in range(12):
        points[x] = reached = gap(x)
        below = max(v for v in points if points[v] < target)
        above = min((v for v in points if points[v] >= target and v > below), default=math.inf)
        if abs(reached / target - 1) < 0.05 or below >= most:
            break
        x = min(most, max(below, guess / 9) * min(3.0, 1.1 * target / max(points[below], 1e-9)))
        if not math.isinf(above):
            x = below + (above - below) * min(0.9, max(0.1, (target - points[below]) / (points[above] - points[below])))
    x = min(points, key=lambda v: abs(points[v] - target))
    if abs(points[x] / target - 1) > 0.15:
        raise ValueError(f"the law reaches {1e3 * max(points.values()):.2f} mm, not {1e3 * target:.2f} mm")
    return x, points[x]

def record(folder: Path, seed: int, laws: Sequence[tuple[str, str]], *, smooth: bool = False) -> dict:
    """Writes one dataset and returns what is true of it."""
    rng = np.random.default_rng(seed)
    p, trials, noise = _plant(rng), _program(rng), float(rng.uniform(0.15, 0.6)) * 1e-3
    k, c, cut, wide = (float(rng.uniform(*span)) for span in ((0.85, 1.15), (0.6, 1.4), (8, 15), (0.05, 0.12)))
    arm, truth, filtered, peak = copy.deepcopy(p), [], rng.random() < 0.5, max(abs(t.tau(t.t)).max() / t.keq / k for t in trials)

    def seen(plant: Plant, change: Sequence[float] = (0.0, 0.0)) -> np.ndarray:
        """All coordinates from the releases on, with relative changes of the compliance and of the damping."""
        tracks = _tracks(plant, trials, (k / (1 + change[0]), c * (1 + change[1])), SIZE_STEP)
        return np.concatenate([track[trial.release:].ravel() for track, trial in zip(tracks, trials)])

    def gap(x: float) -> float:
        """RMS distance (m) of the markers from the arm without the law, refitted twice: linearly, and again from where that ends."""
        changed = copy.deepcopy(p)
        _apply(changed, name, x, seed, peak)
        left = (moved := seen(changed)) - seen(p, np.clip(np.linalg.lstsq(slopes, moved - plain)[0], -0.7, 3.0))
        return float(np.linalg.norm(left - slopes @ np.linalg.lstsq(slopes, left)[0])) * math.sqrt(2 / len(plain))

    if laws:
        plain = seen(p)
        slopes = np.stack([(seen(p, (0.02, 0.0)) - plain) / 0.02, (seen(p, (0.0, 0.05)) - plain) / 0.05], axis=1)
    for name, size in laws:
        x, reached = _strength(gap, min(CAP, SIZES[size] * math.sqrt(2) * noise), *LAWS[name][1:3])
        truth.append({"name": name, "parameters": _apply(arm, name, x, seed, peak), "gap_mm": 1e3 * reached})
    Path(folder).mkdir(parents=True, exist_ok=True)
    lines = [f'format = 1\nname = "tendon-arm-{seed}"\n\n[robot]\nlength = {LENGTH}\nmass = {MASS}\ndiameter = {DIAMETER}',
             f'mount = "{"upright" if p.upright else "hanging"}"']
    names = ["m1", "m2", "m3"][:len(p.markers) - 1] + ["tip"]
    lines += [f'\n[[marker]]\nname = "{name}"\narc_length = {s:.3f}' for name, s in zip(names, p.markers)]
    for index, (trial, track) in enumerate(zip(trials, _tracks(arm, trials, (k, c)))):
        rate, driven, file = 1 / trial.t[1], trial.kind != "release", f"trial_{index + 1:02d}.csv"
        places = np.insert(track, 1, 0.0, axis=2) + noise * rng.standard_normal(track.shape[:2] + (3,))
        if smooth and filtered:
            places = signal.sosfiltfilt(signal.butter(2, cut, fs=rate, output="sos"), places, axis=0)
        elif smooth:
            places = signal.savgol_filter(places, int(rate * wide) // 2 * 2 + 3, 2, axis=0)
        head = ["t"] + ["tau"] * driven + [f"{name}_{axis}" for name in names for axis in "xyz"]
        table = np.column_stack([trial.t] + [trial.tau(trial.t + 1e-7)] * driven + [places.reshape(len(trial.t), -1)])
        np.savetxt(Path(folder) / file, table, fmt="%.6f", delimiter=",", header=",".join(head), comments="")
        lines += [f'\n[[trial]]\nfile = "{file}"\nkeq = {trial.keq}\ndamping = {trial.damping}']
        lines += [f"t_start = {trial.t[trial.release]:.6f}"] * (trial.kind == "held")
    (Path(folder) / "dataset.toml").write_text("\n".join(lines) + "\n")
    how = (f"Butterworth both ways, {cut:.1f} Hz" if filtered else f"Savitzky-Golay, {wide:.3f} s") if smooth else "none"
    return {"laws": truth, "keq_factor": k, "damping_factor": c, "noise_mm": 1e3 * noise, "smooth": smooth, "smoothing": how}

def check() -> None:
    """Prints how well the plant agrees with theory and with finer steps."""
    p, moment = _plant(np.random.default_rng(3)), RADIUS * 50.0
    arm = _arm(p, 1.5, 0.05)._replace(ga=0.0, preset=0 * p.k)
    bend = np.ptp(_run(arm, np.full((2, 2), (70.0, 20.0)), np.zeros((2, 2)), STEP, 1, SETTLE_STEP, SETTLE_COUNT)[0, :p.n + 1])
    print(f"bend under {moment} Nm: {bend:.6f} rad, theory {moment / (1.5 - 90.0 * LENGTH / DISCS ** 2 / 12):.6f}")
    trials, fine = _program(np.random.default_rng(4)), _plant(np.random.default_rng(3), 4 * DISCS)
    for what, other, step in (("8 times finer steps", p, STEP / 8), ("4 times the segments", fine, STEP)):
        other = _tracks(other, trials, (1, 1), step)
        far = max(math.sqrt(2 * np.mean((a - b)[:, -1] ** 2)) for a, b in zip(_tracks(p, trials, (1, 1)), other))
        print(f"{what} move the tip by {1e3 * far:.4f} mm RMS in the worst trial")
    start = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        print(record(Path(folder), 5, [("soft_spot", "medium")])["laws"], f"{time.process_time() - start:.1f} s of one core")

if __name__ == "__main__":
    check()
