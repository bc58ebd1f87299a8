"""A soft planar arm bent by two antagonistic pneumatic muscles: recordings with known missing laws, for blind judging.

Mechanics: a planar inextensible Kirchhoff rod, r' = (sin th, cos th), th' = kappa, written in its strains (Boyer et al. 2021).
The curvature is linear inside each of five elements and free to jump between them; angles and positions follow by integration.
Alexander's two-stage SDIRK rule with Newton's method advances it in time. All bending laws act at the 15 Gauss points.
Actuation: a torque command u becomes two pressure goals p0 + max(+-u, 0)/GEAR. A chamber obeys dp/dt = n (R T mdot - p dV/dt)/V
with a volume that changes as the arm bends; its regulator meters the flow in proportion to the error, or through an orifice
after ISO 6358 (choked or not). The bending moment is GEAR (p2 - p1) times a profile along the arm. Without a law the valve
needs 0.1 ms and the profile is even. A command holds from its row until the next row (no interpolation between rows).
Nuisances of every arm: rotary inertia of the sections, air drag, a moment uneven by 0.3 %, a rest bend of 0.003 1/m.
A law's gap is measured on the arm that has this law alone, also when several are recorded. `python valve_arm.py`: self-check.
"""
from __future__ import annotations
import copy
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
import numpy as np
from numba import njit
from scipy.signal import butter, filtfilt, savgol_filter

_LOADED_AS, __name__ = __name__, "valve_arm"                # One name for numba's cache, however this module was loaded.
sys.modules.setdefault(__name__, sys.modules.get(_LOADED_AS) or type(sys)(__name__))
LENGTH, MASS, DIAMETER, GRAVITY = 0.24, 0.15, 0.04, 9.81    # m, kg, m, m/s^2
GEAR = 1 / 1.5e5                                            # N m per Pa: muscle area times lever arm, 1.5 bar for 1 N m.
BAR, SUPPLY, ATMOSPHERE, POLYTROPIC = 1e5, 6e5, 1e5, 1.2    # Pa, Pa, Pa, exponent of the gas
CELLS, FINE, COARSE, SETTLE = 5, 1e-3, 5e-3, 5e-2           # Cells of a slow line; s: steps of record, sizing and settling.
SIZES = {"barely": 2.0, "medium": 6.0, "large": 15.0}       # Gap in noise floors.
EI, DAMP, REST, PROFILE, DENSITY, PLAY, CELL, PLACE, WEIGHT = range(9)      # Columns of Arm.section.
SCALARS = np.dtype([(name, "f8") for name in (
    "gx gz payload ahead elastic_form elastic_b stop_plus stop_minus rate_c rate_n stribeck dahl_k dahl_y clamp drag_linear "
    "drag_square p0 volume orifice t_fill t_vent c_fill c_vent dead gain_plus gain_minus saturation threshold bias band "
    "cool_share cool_time line_time pressure_stiff restraint_form restraint_k restraint_x stretch stretch_pressure").split()]
    + [("share", "f8", 3), ("relax", "f8", 3), ("slip_k", "f8", 4), ("slip_y", "f8", 4)])

@njit(cache=True)
def _section(a, sec, kappa, rate, old, new, h, settle, stiff):
    """Return a section's moment [N m], stiffness [N m^2] and viscosity [N m^2 s]; write its new inner state."""
    e, b, d, step = kappa - sec[REST], a.elastic_b, sec[DAMP], kappa - old[8]
    slope = 1e-3 if abs(e) < sec[PLAY] else 1.0             # Free play: hardly any elastic moment inside the gap.
    e -= 0.999 * min(max(e, -sec[PLAY]), sec[PLAY])
    m, k = e, 1.0
    if a.elastic_form == 1:                                 # Duffing's cubic.
        m, k = e + b * e**3, 1.0 + 3.0 * b * e * e
    elif a.elastic_form == 2:                               # Exponential stiffening after Fung.
        m, k = np.sinh(b * e) / b, np.cosh(b * e)
    elif a.elastic_form == 3:                               # Softening, inverse hyperbolic sine.
        m, k = np.arcsinh(b * e) / b, 1.0 / np.sqrt(1.0 + b * b * e * e)
    m, k = sec[EI] * stiff * m, sec[EI] * stiff * k * slope
    grow = abs(a.rate_c * rate) ** a.rate_n
    m, d = m + d * rate * (1.0 + grow), d * (1.0 + (1.0 + a.rate_n) * grow)
    for side, edge in ((1.0, a.stop_plus), (-1.0, a.stop_minus)):
        over, push = side * kappa - edge, 30.0 * sec[EI] * max(1.0 + 0.02 * side * rate, 0.0)
        if over > 0.0:                                      # Locked links: a stiff stop with Hunt and Crossley's damping.
            m, k, d = m + side * push * over, k + push, d + 0.6 * sec[EI] * over
    for j in range(3):                                      # Maxwell branches, exact for a constant rate.
        if a.share[j] > 0.0 and not settle:
            fade = np.exp(-h / a.relax[j])
            gain = a.share[j] * sec[EI] * a.relax[j] / h * (1.0 - fade)
            new[j] = fade * old[j] + gain * step
            m, k = m + new[j], k + gain
    bump = 1.0 + a.stribeck * np.exp(-((old[7] / 0.5) ** 2))    # Stribeck's peak, at the rate of the step before.
    for j in range(4):                                      # Jenkins elements: a spring that slips at its yield moment.
        spring, top = a.slip_k[j] * sec[EI], a.slip_y[j] * bump         # Its stiffness is a share of the section's.
        trial = old[3 + j] + spring * step
        new[3 + j] = min(max(trial, -top), top)
        m, k = m + new[3 + j], k + (spring if abs(trial) < top else 0.0)
    if a.dahl_y > 0.0:                                      # Dahl, which is Bouc and Wen with n = 1 and gamma = 0.
        side, spring = (1.0 if step > 0.0 else -1.0), a.dahl_k * sec[EI]
        fade = np.exp(-spring * abs(step) / a.dahl_y)
        new[9] = side * a.dahl_y + (old[9] - side * a.dahl_y) * fade
        m, k = m + new[9], k + spring * fade * (1.0 - side * old[9] / a.dahl_y)
    new[7], new[8] = rate, kappa
    return m, k, d

@njit(cache=True)
def _chamber(a, p, goal, vol, dvol, h):
    """Return a chamber's pressure [Pa] after a time h: four implicit Euler steps by bisection (the inflow falls as the pressure rises)."""
    spare = 1.0 + POLYTROPIC * max(p, goal) * abs(dvol) * h / vol       # Pa that the changing volume may add or take.
    for _ in range(4):
        low, high = min(p, goal) - spare, max(p, goal) + spare
        while high - low > 1e-2:
            now = 0.5 * (low + high)
            e = goal - now - min(max(goal - now, -a.band), a.band)
            q = e / (a.t_fill if e > 0.0 else a.t_vent) * a.volume / vol            # A metering valve.
            if a.orifice > 0.0:                             # ISO 6358: sonic conductance, critical pressure ratio 0.3.
                up, down, c = (SUPPLY, now, a.c_fill) if e > 0.0 else (now, ATMOSPHERE, a.c_vent)
                x = max(min(down / up, 1.0) - 0.3, 0.0) / 0.7
                q = POLYTROPIC * BAR * c * up * min(max(e / BAR, -1.0), 1.0) / vol * np.sqrt(1.0 - x * x)
            rises = now - p < 0.25 * h * (q - POLYTROPIC * now * dvol / vol)
            low, high = (now, high) if rises else (low, now)
        p = 0.5 * (low + high)
    return p

@njit(cache=True)
def _command(a, u, t, h, dt):
    """Return the mean torque goal from t to t + h, after dead time, gains, threshold, saturation and bias."""
    t0, t1, last = max(t - a.dead, 0.0) / dt, max(t + h - a.dead, 0.0) / dt, len(u) - 1
    i, j = min(int(t0 + 1e-7), last), min(int(max(t1 - 1e-7, 0.0)), last)
    c = u[i] if i == j else (u[i] * (j - t0) + u[j] * (t1 - j)) / (t1 - t0)
    c *= a.gain_plus if c > 0.0 else a.gain_minus
    c -= min(max(c, -a.threshold), a.threshold)
    return (a.saturation * np.tanh(c / a.saturation) if a.saturation > 0.0 else c) + a.bias

@njit(cache=True)
def _run(scalars, section, phi, turn, place, u, pull, dt, sub):
    """Return curvatures, their rates and the stretch at every row, for torques u [N m] and sideways tip pulls [N] per row.
    phi, turn, place: curvature, angle and position rows of the Gauss points, then of the tip and of the payload."""
    a, g, n, w = scalars[0], phi.shape[0], phi.shape[1], section[:, WEIGHT]
    tip, load, base, gamma = g, g + 1, n - 1, 1.0 - np.sqrt(0.5)
    q, q0, v0, a1, v1 = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    out, rates, stretches = np.zeros((len(u), n)), np.zeros((len(u), n)), np.zeros(len(u))
    old, new, rows = np.zeros((g, 10)), np.zeros((g, 10)), np.zeros((4 * g + 4, n))
    rows[2 * g + 4:3 * g + 4], rows[3 * g + 4:] = phi, turn[:g]         # After the sideways and lengthwise rows of the points.
    lump, wet = np.zeros(g + 2), np.zeros(g + 2)            # kg and m per point
    lump[:g], wet[:g], lump[load] = w * section[:, DENSITY], w, a.payload
    gas, was, tap = np.zeros((2, CELLS + 3)), np.zeros((2, CELLS + 3)), np.zeros(CELLS)
    line = 2.0 * np.eye(CELLS) - np.eye(CELLS, k=1) - np.eye(CELLS, k=-1)
    line[-1, -1], tap[0] = 1.0, 1.0
    for twice in range(-120, 2 * (len(u) - 1) * sub):          # Two stages a step; 60 long steps to settle.
        count, stage, settle = twice // 2, twice % 2, twice < 0
        dh, t, row = (SETTLE, 0.0, 0) if settle else (dt / sub, count * dt / sub, count // sub)
        k, h = gamma * dh, dh if stage else gamma * dh      # The implicit part of the stage, and its time since the last step.
        qb, vb = (q0 + (dh - k) * v1, v0 + (dh - k) * a1) if stage else (q0, v0)
        c = _command(a, u, t, 0.0 if settle else dh, dt)
        bend, spin = turn[tip, :base] @ q0[:base], turn[tip, :base] @ v0[:base]
        for i in range(2):                                  # Columns of gas: cells, valve side, cooled goal, axial strain.
            side = 2.0 * i - 1.0
            goal = a.p0 + max(side * c, 0.0) / GEAR
            gas[i, -2] = goal if settle else goal + (was[i, -2] - goal) * np.exp(-h / a.cool_time)
            goal += a.cool_share * (goal - gas[i, -2])      # A hot charge of air that cools.
            gas[i, -3] = goal if settle else _chamber(a, was[i, -3], goal, a.volume + side * GEAR * bend, side * GEAR * spin, h)
            slow, f = not settle and a.line_time > 0.0, 0.25 * h * CELLS**2 / max(a.line_time, 1e-9)
            gas[i, :CELLS] = was[i, :CELLS] if slow else np.full(CELLS, gas[i, -3])
            for _ in range(4 if slow else 0):               # Linearised laminar flow from cell to cell, entered at the base.
                gas[i, :CELLS] = np.linalg.solve(np.eye(CELLS) + f * line, gas[i, :CELLS] + f * gas[i, -3] * tap)
            over = (gas[i, -3] - a.p0) * GEAR * a.stretch_pressure
            gas[i, -1] = over if settle else over + (was[i, -1] - over) * np.exp(-h / 0.05)
        excess, lam = (gas[0, -3] + gas[1, -3] - 2 * a.p0) * GEAR, a.stretch + gas[0, -1] + gas[1, -1]
        q[:] = qb + k * v0
        for _ in range(30):
            v, acc = (q - qb) / k, ((q - qb) / k - vb) / k
            angle, omega = turn @ q, turn @ v
            s, co, ahead = lam * np.sin(angle), lam * np.cos(angle), a.ahead / lam
            jx, jz = rows[:g + 2], rows[g + 2:2 * g + 4]
            jx[:], jz[:] = place @ (co[:g].reshape(-1, 1) * turn[:g]), place @ (-s[:g].reshape(-1, 1) * turn[:g])
            jx[load], jz[load] = jx[load] + ahead * co[tip] * turn[tip], jz[load] - ahead * s[tip] * turn[tip]
            ax, az = jx @ acc - place @ (s[:g] * omega[:g] ** 2), jz @ acc - place @ (co[:g] * omega[:g] ** 2)
            ax[load], az[load] = ax[load] - ahead * s[tip] * omega[tip] ** 2, az[load] - ahead * co[tip] * omega[tip] ** 2
            vx, vz, x = jx @ v, jz @ v, place[tip] @ s[:g]
            drag, force, stiff = wet * (a.drag_linear + a.drag_square * np.hypot(vx, vz)), np.zeros(4 * g + 4), np.zeros(4 * g + 4)
            force[:g + 2], force[g + 2:2 * g + 4] = lump * (ax - a.gx) + drag * vx, lump * (az - a.gz) + drag * vz
            stiff[:g + 2], stiff[g + 2:2 * g + 4] = lump / k**2 + drag / k, lump / k**2 + drag / k
            dx, pad = x - a.restraint_x, 0.01 if a.restraint_form == 2 else 0.0         # m beyond the restraint; s of its padding
            met = a.restraint_form == 1 or (a.restraint_form == 2 and min(dx * a.restraint_x, (dx + pad * vx[tip]) * a.restraint_x) > 0.0)
            hard = a.restraint_k if met else 0.0            # A taut rubber band, or a padded wall that is touched.
            force[tip] += hard * (dx + pad * vx[tip]) - pull[row] - (a.restraint_k if a.restraint_form == 3 else 0.0)
            stiff[tip] += hard * (1.0 + pad / k)
            for i in range(g):
                m, spring, d = _section(a, section[i], phi[i] @ q, phi[i] @ v, old[i], new[i], h, settle, 1.0 + a.pressure_stiff * excess)
                m -= GEAR * (gas[1, int(section[i, CELL])] - gas[0, int(section[i, CELL])]) * section[i, PROFILE]
                rotary = lump[i] * DIAMETER**2 / 16.0
                force[2 * g + 4 + i], stiff[2 * g + 4 + i] = w[i] * m, w[i] * (spring + d / k)
                force[3 * g + 4 + i], stiff[3 * g + 4 + i] = rotary * (turn[i] @ acc), rotary / k**2
            r, matrix = rows.T @ force, rows.T @ (stiff.reshape(-1, 1) * rows)
            r[base] += a.clamp * (q[base] + 0.02 * v[base]) - GEAR * (gas[1, 0] - gas[0, 0])   # The muscles end behind the clamp.
            matrix[base, base] += a.clamp * (1.0 + 0.02 / k)
            dq = np.linalg.solve(matrix, r)
            q -= dq
            if not np.max(np.abs(dq)) > 1e-6:
                break
        v1[:], a1[:] = (q - qb) / k, ((q - qb) / k - vb) / k
        if stage:
            q0[:], v0[:], old[:], was[:] = q, v1, new, gas
            if count == -1 or (not settle and (count + 1) % sub == 0):
                out[(count + 1) // sub], rates[(count + 1) // sub], stretches[(count + 1) // sub] = q, v1, lam
    return out, rates, stretches

@dataclass(frozen=True)
class Trial:
    """Torques [N m] and sideways tip pulls [N] per row; the first row that counts; whether the file shows command and earlier rows."""
    t: np.ndarray
    torque: np.ndarray
    pull: np.ndarray
    keq: float
    first: int = 0
    shown: bool = True

@lru_cache(maxsize=256)
def mesh(elements: int, points: tuple[float, ...]) -> tuple[np.ndarray, ...]:
    """Return points and Gauss weights [m], and curvature, angle and position rows; no points means Gauss points, tip and payload."""
    xi, wi = np.polynomial.legendre.leggauss(3)
    size, starts = LENGTH / elements, np.arange(elements) * LENGTH / elements
    cuts = np.array(points or [*(starts[:, None] + (xi + 1) * size / 2).ravel(), LENGTH, LENGTH])
    raw = (cuts[:, None] - starts) / size * 2 - 1
    end, inside, flat, clamp = np.clip(raw, -1, 1), 1.0 * (np.abs(raw) < 1), (len(cuts), -1), np.ones((len(cuts), 1))
    nodal = [np.polynomial.Polynomial(np.linalg.solve(np.vander(xi, 3, True), row)).integ(lbnd=-1) for row in np.eye(3)]
    curvature = np.hstack([np.stack([inside, inside * end], 2).reshape(flat), 0 * clamp])     # The last column is the clamp's angle.
    angle = np.hstack([np.stack([end + 1, (end**2 - 1) / 2], 2).reshape(flat) * size / 2, clamp])
    place = np.stack([f(end) for f in nodal], 2).reshape(flat) * size / 2
    return cuts, np.tile(wi, elements) * size / 2, curvature, angle, place

class Arm:
    """An arm with its laws: scalars, a row of constants per Gauss point, and how the camera sees the markers."""
    def __init__(self, hanging: bool, places: Sequence[float], elements: int = 5) -> None:
        s, w = mesh(elements, ())[0][:-2], mesh(elements, ())[1]
        one, self.up, self.elements = np.ones(len(s)), 1.0 if hanging else -1.0, elements
        self.places, self.off, self.zoom = np.array(places, float), np.zeros(len(places)), np.ones(2)  # m, m to the side, share
        self.section = np.stack([one, one, 0 * s, one, one * MASS / LENGTH, 0 * s, s // (LENGTH / CELLS), s, w], axis=1)
        self.scalars = np.zeros(1, SCALARS)
        self.put(stop_plus=1e9, stop_minus=1e9, rate_n=1.0, p0=2e5, volume=4e-4, t_fill=1e-4, t_vent=1e-4, gain_plus=1.0,
                 gain_minus=1.0, stretch=1.0, clamp=1e7, cool_time=1.0)
        self.tilt(0.0, 0.0)

    def put(self, **values: float | Sequence[float]) -> None:
        """Set scalars by name."""
        for name in values:
            self.scalars[name] = values[name]

    def tilt(self, angle: float, seen: float) -> None:
        """Tilt the base by an angle [rad] towards +x; `seen` is the part of it that the camera sees."""
        self.put(gx=-self.up * GRAVITY * np.sin(angle), gz=self.up * GRAVITY * np.cos(angle))
        self.view = seen

    def move(self, trial: Trial, keq: float, damping: float, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return curvatures, rates and stretch per row, for whole-arm constants keq [Nm/rad] and damping [Nm s/rad]."""
        _, _, curvature, turn, place = mesh(self.elements, ())
        section, dt = self.section.copy(), trial.t[1] - trial.t[0]
        section[:, [EI, DAMP]] *= np.array([keq, damping]) * LENGTH
        result = _run(self.scalars, section, curvature[:-2], turn, place, trial.torque, trial.pull, dt, int(np.ceil(dt / step - 1e-9)))
        if not np.all(np.isfinite(result[0])):
            raise ValueError("the arm diverged")
        return result

    def see(self, trial: Trial, keq: float, damping: float, step: float) -> np.ndarray:
        """Return the world x and z [m] of every marker at every row: rows x markers x 2."""
        q, _, stretch = self.move(trial, keq, damping, step)
        _, _, _, turn, place = mesh(self.elements, tuple(self.places))
        angle, here = q @ mesh(self.elements, ())[3][:-2].T, q @ turn.T
        x = stretch[:, None] * (np.sin(angle) @ place.T) + self.off * np.cos(here)
        z = stretch[:, None] * (np.cos(angle) @ place.T) - self.off * np.sin(here)
        c, s = np.cos(self.view), np.sin(self.view)
        return self.zoom * np.stack([x * c + z * s, self.up * (x * s - z * c)], axis=2)

# ---------------------------------------------------------------- the laws: kinds, first and greatest strength x, forms
LAWS: dict[str, tuple[str, float, float, str]] = {
    "stiffness_gradient": ("elastic", 0.3, 1.3, "linear exponential cone"),         # The tip has exp(+-2 x) times the base's value.
    "soft_spot": ("elastic", 0.5, 6.0, "one_fifth graded"),                         # log of the compliance (or of the stiffness) there
    "preset_bend": ("elastic", 0.3, 8.0, "to_tip to_base outer_part wave"),         # 1/m; never uniform, that is torque_bias
    "stiffening": ("elastic", 0.2, 8.0, "cubic sinh asinh"),                        # m
    "bending_stop": ("elastic contact", 0.4, 100.0, "two_sided plus_side minus_side"),  # m: one over the curvature of the stop
    "backlash": ("friction elastic", 0.3, 4.0, "all_links two_fifths"),             # 1/m, half the gap
    "dry_friction": ("friction", 0.05, 0.6, "coulomb stribeck dahl"),               # N m
    "hysteresis": ("friction", 0.2, 4.0, "iwan bouc_wen"),                          # stiffness before slip, share of the arm's
    "viscoelastic": ("creep", 0.2, 5.0, "zener prony power_law"),                   # share of the stiffness that relaxes
    "quadratic_damping": ("damping", 0.2, 100.0, "rate rate_squared outer_drag"),   # m s, m s, 10 N s^2/m^3 along the arm
    "damping_gradient": ("damping", 0.8, 3.0, "linear exponential cone two_parts"),
    "actuator_lag": ("actuation_time", 0.03, 0.8, "metering_valve orifice"),        # s
    "unequal_lag": ("actuation_time", 0.04, 1.5, "metering_valve orifice"),         # s, the slower of the two
    "dead_time": ("actuation_time", 0.02, 0.3, "pure_delay"),                       # s
    "torque_bias": ("actuation_map elastic", 0.03, 0.6, "regulator_zero"),          # N m; at one keq like a uniform rest bend
    "torque_map": ("actuation_map", 0.1, 3.0, "unequal_sides saturation threshold"),    # log of a ratio, 1/(N m), 0.3 N m
    "torque_decay": ("actuation_map", 0.6, 4.0, "taper leaky_line capstan"),
    "gravity_tilt": ("mass_gravity", 0.05, 0.9, "frame_upright frame_along_base"),  # rad
    "tip_mass": ("mass_gravity", 0.04, 0.4, "at_tip ahead_of_tip"),                 # kg
    "added_mass": ("mass_gravity", 0.1, 0.8, "even"),                               # kg
    "restraint": ("contact", 3.0, 400.0, "band padded_wall pulley"),                # N/m, 4 N/m, 0.1 N
    "marker_offset": ("measurement", 0.002, 0.04, "one_side each_its_own"),         # m
    "marker_slip": ("measurement", 0.002, 0.06, "one_marker"),                       # m
    "length_change": ("measurement elastic", 0.01, 0.5, "other_length pressure"),   # share; axial inertia is left out
    "camera_scale": ("measurement", 0.01, 0.3, "both_axes x_only z_only"),
    "slow_line": ("actuation_time", 0.06, 3.0, "diffusion"),                        # s: the pressure reaches the tip late
    "valve_deadband": ("actuation_map friction", 0.05, 0.9, "overlap"),             # bar: the valve rests short of its goal
    "flexible_clamp": ("elastic", 0.05, 4.0, "spring"),                             # rad/(N m): the base turns
    "medium_drag": ("damping", 4.0, 100.0, "stokes"),                               # N s/m^2: linear drag along the arm
    "gas_cooling": ("actuation_time creep", 0.1, 4.0, "overshoot"),                 # share of a new pressure that fades
    "pressure_stiffening": ("elastic actuation_map", 0.2, 8.0, "sum_pressure")}     # 1/(N m): stiffer under pressure
CATALOGUE: dict[str, tuple[str, ...]] = {name: tuple(row[0].split()) for name, row in list(LAWS.items())[:-6]}
OUTSIDE: dict[str, tuple[str, ...]] = {name: tuple(row[0].split()) for name, row in list(LAWS.items())[-6:]}

def apply_law(name: str, arm: Arm, x: float, rng: np.random.Generator) -> dict:
    """Put a law of strength x on an arm and return its parameters; the generator chooses form, side and place."""
    form, side, pick = str(rng.choice(LAWS[name][3].split())), float(rng.choice([-1, 1, 1])), int(rng.integers(0, 4))
    draw, section, s, y = rng.random(), arm.section, arm.section[:, PLACE] / LENGTH, side * x
    slope, away, time, reach = side * (2 * s - 1), np.abs(s * 5 // 1 - pick), 0.25 + 0.65 * draw, 0.4 + 0.6 * draw
    low, mid = x / (3 + 5 * draw if name == "unequal_lag" else 1.0), float(arm.scalars["p0"][0]) + 0.5 * BAR
    fill, vent = (low, x) if pick else (x, low)             # An open orifice moves 1 bar in this time, at 0.5 bar over p0.
    c_fill, c_vent = [float(arm.scalars["volume"][0]) / (POLYTROPIC * q * up * np.sqrt(1 - max((r - 0.3) / 0.7, 0) ** 2))
                      for q, up, r in ((fill, SUPPLY, mid / SUPPLY), (vent, mid, ATMOSPHERE / mid))]
    scalars: dict[str, dict] = {
        "cubic": dict(elastic_form=1, elastic_b=x * x), "sinh": dict(elastic_form=2, elastic_b=x), "asinh": dict(elastic_form=3, elastic_b=x),
        "two_sided": dict(stop_plus=1 / x, stop_minus=1 / x), "plus_side": dict(stop_plus=1 / x), "minus_side": dict(stop_minus=1 / x),
        "coulomb": dict(slip_k=[60, 0, 0, 0], slip_y=[x, 0, 0, 0]), "dahl": dict(dahl_k=30.0, dahl_y=x),
        "stribeck": dict(slip_k=[60, 0, 0, 0], slip_y=[x, 0, 0, 0], stribeck=0.4),
        "iwan": dict(slip_k=[x / 4] * 4, slip_y=x * 0.09 * reach * np.array([0.4, 0.9, 1.6, 2.6])),     # Slips at `reach` in 1/m.
        "bouc_wen": dict(dahl_k=x, dahl_y=x * 0.36 * reach), "zener": dict(share=[x, 0, 0], relax=[time] * 3),
        "prony": dict(share=[0.4 * x, 0.3 * x, 0.3 * x], relax=[0.35 * time, time, 3 * time]),
        "power_law": dict(share=[0.55 * x, 0.28 * x, 0.17 * x], relax=[0.35 * time, time, 3 * time]),
        "rate": dict(rate_c=x, rate_n=1.0), "rate_squared": dict(rate_c=x, rate_n=2.0), "outer_drag": dict(drag_square=10 * x),
        "metering_valve": dict(t_fill=fill, t_vent=vent), "orifice": dict(orifice=1.0, c_fill=c_fill, c_vent=c_vent, t_fill=fill, t_vent=vent),
        "pure_delay": dict(dead=x), "regulator_zero": dict(bias=y), "unequal_sides": dict(gain_plus=np.exp(y / 2), gain_minus=np.exp(-y / 2)),
        "saturation": dict(saturation=1 / x), "threshold": dict(threshold=0.3 * x),
        "at_tip": dict(payload=x), "ahead_of_tip": dict(payload=x, ahead=0.02),
        "band": dict(restraint_form=1, restraint_k=x, restraint_x=0.05 * side), "pulley": dict(restraint_form=3, restraint_k=0.1 * y),
        "padded_wall": dict(restraint_form=2, restraint_k=4 * x, restraint_x=side * (0.01 + 0.02 * draw)),
        "other_length": dict(stretch=1 + y), "pressure": dict(stretch_pressure=x), "diffusion": dict(line_time=x), "overlap": dict(band=x * BAR),
        "spring": dict(clamp=1 / x), "stokes": dict(drag_linear=x), "overshoot": dict(cool_share=x, cool_time=time),
        "sum_pressure": dict(pressure_stiff=x)}
    scaled: dict[str, np.ndarray] = {
        "linear": 1 + np.tanh(x) * slope, "exponential": np.exp(x * slope), "cone": (1 + np.tanh(x / 4) * slope) ** 4,
        "two_parts": np.exp(np.where(s < 0.4, -y, y)), "one_fifth": np.exp(-y * (away == 0)),
        "graded": np.exp(-y * ((away == 0) + 0.4 * (away == 1))), "capstan": np.exp(-x * s),    # Friction of the muscle's sheath.
        "taper": np.maximum(1 - x * s, 0), "leaky_line": np.cosh(x * (1 - s)) / np.cosh(x)}     # A tapered bore; laminar leakage.
    told = {"form": form, "strength": x, "side": side} | {key: np.asarray(value).tolist() for key, value in scalars.get(form, {}).items()}
    told |= {"fifth": pick} if name in ("soft_spot", "backlash") else {}
    arm.put(**scalars.get(form, {}))
    if form in scaled:
        section[:, {"damping_gradient": DAMP, "torque_decay": PROFILE}.get(name, EI)] *= scaled[form]
    elif name == "preset_bend":
        section[:, REST] += y * {"to_tip": s, "to_base": 1 - s, "outer_part": 1.0 * (s > 0.4), "wave": np.cos(np.pi * s)}[form]
    elif name == "backlash":
        section[:, PLAY] = x * (np.abs(s * 5 - pick - 1) < (9 if form == "all_links" else 1))
    elif name == "added_mass":
        section[:, DENSITY] += x / LENGTH
    elif name == "gravity_tilt":
        arm.tilt(y, y if form == "frame_upright" else 0.0)
    elif name == "camera_scale":
        arm.zoom = 1 + y * np.array([form != "z_only", form != "x_only"])
    elif name == "marker_offset":
        arm.off = y * (np.ones(len(arm.places)) if form == "one_side" else rng.uniform(-1.5, 1.5, len(arm.places)))
        told["offsets_m"] = arm.off.tolist()
    elif name == "marker_slip":
        which = told["marker"] = pick % len(arm.places)
        told["slip_m"] = -x if arm.places[which] + y > LENGTH else y
        arm.places[which] += told["slip_m"]
    return told

def program(rng: np.random.Generator, rate: int, levels: Sequence[float]) -> list[Trial]:
    """Return 5 to 8 trials: steps, staircases, sines, chirps, and releases of an arm held by a thread or by its muscles."""
    trials, more = [], rng.choice(["chirp", "steps", "release", "stairs"], rng.integers(0, 4))
    for number, name in enumerate(["steps", "stairs", "sine", "release", "steps", *more]):
        t = np.arange(int(rng.uniform(3.6 if name == "release" else 2.5, 5.0) * rate)) / rate
        keq, side, first = levels[number % len(levels)], rng.choice([-1, 1]), 0
        u, pull, shown, high = np.zeros(len(t)), np.zeros(len(t)), True, side * min(rng.uniform(0.45, 0.85) * keq, 1.0)
        if name == "steps":
            parts = int(rng.integers(2, 5))
            for part, share in enumerate(rng.uniform(0.4, 1.0, parts) * rng.choice([-1, 1, 1], parts)):
                u[t >= 0.2 + part * (t[-1] - 0.2) / parts] = high * share
        elif name == "stairs":
            u = high * np.array([0, 1, 2, 3, 2, 1, 0, -1.5, -3, -1.5])[(t / t[-1] * 9.99).astype(int)] / 3
        elif name == "sine":
            u = high * np.sin(2 * np.pi * rng.uniform(0.4, 1.2) * np.maximum(t - 0.2, 0))
        elif name == "chirp":
            u = 0.8 * high * np.sin(2 * np.pi * (0.3 * t + rng.uniform(0.25, 0.5) * t * t / 2))
        else:                                               # A thread (hidden or shown rows) or the muscles hold the arm first.
            first, shown = int(0.4 * len(t)), (how := int(rng.integers(0, 3))) > 0
            held = np.where(np.arange(len(t)) < first, 0.5 - 0.5 * np.cos(np.pi * np.clip(t / 0.6, 0, 1)), 0.0)
            u, pull = (held * high, u) if how == 2 else (u, held * side * 3 * keq * rng.uniform(0.04, 0.08) / LENGTH**2)
        trials.append(Trial(t, np.round(u, 4), pull, keq, first, shown))
    return trials

def record(folder: Path, seed: int, laws: Sequence[tuple[str, str]], *, smooth: bool = False) -> dict:
    """Write a dataset of this seed with the laws (name, size) and return the truth; raise ValueError if a law cannot reach its size."""
    if any({name for name, _ in laws} >= pair for pair in ({"dry_friction", "hysteresis"}, {"actuator_lag", "unequal_lag"})):
        raise ValueError("these two laws share one place in this arm")
    rng = np.random.default_rng(seed)
    hanging, rate, noise = bool(rng.random() < 0.6), int(rng.choice([50, 60, 80, 100, 120])), float(rng.uniform(0.15, 0.6)) * 1e-3
    inner = [[0.5], [0.4, 0.7], [0.3, 0.55, 0.8]][rng.integers(0, 3)]
    places = [*np.round(np.array(inner) * LENGTH + rng.uniform(-0.01, 0.01), 3), LENGTH]
    levels = np.round(rng.uniform(1.0, 1.5) * np.array([[1.0, 1.0], [1.0, 1.33]][rng.integers(0, 2)]), 3)
    damping, factors = float(np.round(rng.uniform(0.03, 0.08), 4)), np.array([rng.uniform(0.86, 1.15), rng.uniform(0.65, 1.4)])
    trials, plain, told = program(rng, rate, levels), Arm(hanging, places), []
    plain.put(p0=rng.uniform(1.6e5, 2.4e5), volume=rng.uniform(3e-4, 5e-4), drag_square=0.6 * DIAMETER)
    plain.section[:, PROFILE] += rng.choice([-0.003, 0.003]) * np.cos(np.pi * plain.section[:, PLACE] / LENGTH)
    plain.section[:, REST] += rng.choice([-0.003, 0.003])

    def look(arm: Arm, scale: np.ndarray) -> np.ndarray:
        return np.concatenate([arm.see(trial, trial.keq * scale[0], damping * scale[1], COARSE)[trial.first:] for trial in trials])

    def gap(seen: np.ndarray) -> float:
        """Return the RMS marker distance [m] to the lawless arm fitted by Gauss and Newton, its slopes kept up to date by Broyden's rule."""
        left = np.inf
        for _ in range(8):
            step = np.linalg.lstsq(fit["slopes"].reshape(2, -1).T, (seen - fit["seen"]).ravel(), rcond=None)[0]
            step = np.clip(fit["log"] + step, -2.3, 2.3) - fit["log"]
            now, before = look(plain, factors * np.exp(fit["log"] + step)), left
            change = now - fit["seen"] - np.tensordot(step, fit["slopes"], 1)
            fit.update(log=fit["log"] + step, seen=now, slopes=fit["slopes"] + np.multiply.outer(step / (step @ step + 1e-9), change))
            left = min(float(np.sqrt(np.mean(np.sum((now - seen) ** 2, axis=2)))), before)
            if np.abs(step).max() < 0.02 or left > 0.98 * before:
                break
        return left

    base, arm = look(plain, factors), copy.deepcopy(plain)
    slopes = np.stack([(look(plain, factors * np.exp(0.03 * e)) - base) / 0.03 for e in np.eye(2)])
    for name, size in laws:
        goal, (_, x, limit, _), low, high = min(SIZES[size] * np.sqrt(2) * noise, 0.012), LAWS[name], None, None
        dice, reached, best, fit = [seed, list(LAWS).index(name)], 0.0, 0.0, {"log": np.zeros(2), "seen": base, "slopes": slopes}
        for _ in range(16):
            apply_law(name, alone := copy.deepcopy(plain), x, np.random.default_rng(dice))
            reached = gap(look(alone, factors))
            if abs(reached / goal - 1) < 0.08:
                break
            low, high = ((x, reached), high) if reached < goal else (low, (x, reached))
            if low and high:                                # Interpolate between the two in logarithms, away from the ends.
                share = np.log(goal / low[1]) / np.log(high[1] / low[1]) if low[1] > 0.1 * goal else 0.6
                x = low[0] * (high[0] / low[0]) ** min(max(share, 0.1), 0.9)
            elif low and (x >= limit or reached < 0.7 * best):
                break                                       # As strong as it gets, or past the strength that shows most.
            else:
                x, best = min(x * float(np.clip(goal / max(reached, 1e-9), 0.2, 2.0)), limit), max(best, reached)
        if abs(reached / goal - 1) >= 0.08:
            raise ValueError(f"{name} reaches {max(best, reached) * 1e3:.2f} mm of {goal * 1e3:.2f} mm")
        told.append({"name": name, "parameters": apply_law(name, arm, x, np.random.default_rng(dice)), "gap_mm": reached * 1e3})
    folder.mkdir(parents=True, exist_ok=True)
    text = [f'format = 1\nname = "valve-arm-{seed}"\ndescription = "The torque of a row holds until the next row."\n\n[robot]',
            f'length = {LENGTH}\nmass = {MASS}\ndiameter = {DIAMETER}\nmount = "{"hanging" if hanging else "upright"}"\ndamping = {damping}']
    names, cut = [*(f"m{i + 1}" for i in range(len(inner))), "tip"], rng.uniform(6, 12)     # Hz
    text += [f'\n[[marker]]\nname = "{name}"\narc_length = {place}' for name, place in zip(names, places)]
    for number, trial in enumerate(trials, 1):
        flat = arm.see(trial, trial.keq * factors[0], damping * factors[1], FINE)
        tracks = np.stack([flat[..., 0], 0 * flat[..., 0], flat[..., 1]], axis=2).reshape(len(flat), -1)
        tracks += rng.normal(0.0, noise, tracks.shape)
        if smooth:                                          # As exports do it: a two-way Butterworth filter or a Savitzky-Golay fit.
            odd = 2 * int(rate / cut) + 1
            tracks = filtfilt(*butter(2, 2 * cut / rate), tracks, axis=0) if cut < 9 else savgol_filter(tracks, odd, 2, axis=0)
        columns = [trial.t, trial.torque, *tracks.T] if trial.shown else [trial.t[:-trial.first], *tracks[trial.first:].T]
        header = ",".join([*(["t", "tau"] if trial.shown else ["t"]), *(f"{name}_{axis}" for name in names for axis in "xyz")])
        np.savetxt(folder / f"trial_{number:02d}.csv", np.column_stack(columns), "%.6f", ",", header=header, comments="")
        text.append(f'\n[[trial]]\nfile = "trial_{number:02d}.csv"\nkeq = {trial.keq}')
        text += [f"t_start = {trial.t[trial.first]:.6f}"] if trial.first and trial.shown else []
    (folder / "dataset.toml").write_text("\n".join(text) + "\n")
    return {"laws": told, "keq_factor": float(factors[0]), "damping_factor": float(factors[1]), "noise_mm": noise * 1e3, "smooth": smooth}

if _LOADED_AS == "__main__":                                  # The self-check.
    time, (_, w, shape, turn, place) = np.arange(300) / 100.0, mesh(5, ())
    jump = Trial(time, np.where(time < 0.2, 0.0, np.where(time < 1.5, 0.7, -0.7)), 0 * time, 1.3)
    exact = Arm(False, [LENGTH], 20).see(jump, 1.3, 0.05, 2.5e-4)
    errors = [1e3 * np.sqrt(np.mean(np.sum((Arm(False, [LENGTH]).see(jump, 1.3, 0.05, h) - exact) ** 2, axis=2))) for h in (FINE, COARSE)]
    print("RMS tip error [mm] with the steps of record and sizing, against 20 elements and 0.25 ms:", np.round(errors, 4))
    (free := Arm(True, [LENGTH])).put(gx=0.0, gz=0.0)
    bent = free.see(Trial(time, 0 * time + 0.65, 0 * time, 1.3), 1.3, 0.05, FINE)[-1, 0]       # The total angle is 0.5 rad.
    print("off the circle of even curvature [mm]:", 1e3 * (bent - LENGTH / 0.5 * np.array([1 - np.cos(0.5), -np.sin(0.5)])))
    q, v, _ = free.move(Trial(time, 0 * time, np.where(time < 1.5, 2.0, 0.0), 1.3), 1.3, 0.004, FINE)
    th, om = q @ turn[:15].T, v @ turn[:15].T
    speed = ((np.cos(th) * om) @ place[:15].T) ** 2 + ((np.sin(th) * om) @ place[:15].T) ** 2 + DIAMETER**2 / 16 * om**2
    energy = 0.5 * (speed @ w * MASS / LENGTH + 1.3 * LENGTH * (q @ shape[:15].T) ** 2 @ w)
    print(f"energy after a release: {energy[150]:.3f} J, greatest rise {np.diff(energy[150:]).max():.1e} J, left {energy[-1]:.1e} J")
