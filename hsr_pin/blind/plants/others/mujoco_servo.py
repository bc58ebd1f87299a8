"""A plant that nobody told the tool about: a small arm of robot servos that follow position commands, with one hidden fault.

The arms are a pendulum stand, a 2-joint desk arm and a 4-joint desktop arm, with numbers that are usual for STS3215, XL430, XM430,
MX-64 and MX-106.  At each step of MuJoCo a servo pulls with stiffness * (target - encoder) - damping * rotor speed, clipped to
+-limit; the encoder has counts and sits on the output.  A case runs with and without its causes, to size them so that they show.
Row k of trial_NN.csv has the encoders at t_k and the targets sent then, which are held until t_(k+1); no targets: servos off.
"""

import json, math, pathlib  # noqa: E401
import xml.etree.ElementTree as ET

import numpy as np

from hsr_pin.blind.plants.others.mujoco_robot import LEVELS, STEP, TINY, _spec, _text, inverse, misdeclare, rms, split

SETTLE = round(0.8 / STEP)  # steps of standing at the first target before the log
SERVOS = {  # stiffness N m/rad, damping N m s/rad, limit N m, rotor kg m^2 at the joint
    "sts3215": (17.8, 0.60, 2.94, 0.025), "xl430": (9.0, 0.24, 1.4, 0.005), "xm430": (26.0, 0.80, 3.9, 0.011),
    "mx64": (16.0, 0.85, 5.5, 0.012), "mx106": (27.0, 1.20, 7.0, 0.018)}
ARMS = {  # links from base to tip: joint, axis, direction, length m, mass kg; mass at the tip, rated payload kg; home and room of the joints
    "stand": {"links": [("rod", "hinge", "0 1 0", (0, 0, -1), 0.20, 0.045)], "tip": 0.36, "rated": 0, "home": (0.0,), "room": (1.45,),
              "servos": (("mx64",), ("mx106",), ("sts3215",), ("xm430",))},
    "desk": {"links": [("upper", "shoulder", "0 1 0", (0, 0, 1), 0.17, 0.17), ("fore", "elbow", "0 1 0", (1, 0, 0), 0.15, 0.08)], "tip": 0.07,
             "rated": 0.15, "home": (0.2, 0.1), "room": (0.8, 0.85), "servos": (("xm430", "xl430"), ("sts3215", "sts3215"), ("mx64", "xm430"))},
    "desktop": {"links": [("turret", "pan", "0 0 1", (0, 0, 1), 0.055, 0.13), ("upper", "lift", "0 1 0", (0, 0, 1), 0.115, 0.16),
                          ("fore", "elbow", "0 1 0", (1, 0, 0), 0.13, 0.14), ("hand", "wrist", "0 1 0", (1, 0, 0), 0.06, 0.08)],
                "tip": 0.09, "rated": 0.25, "home": (0.0, 0.1, 0.1, 0.3), "room": (1.2, 0.7, 0.7, 0.9),
                "servos": (("sts3215",) * 4, ("xm430", "xm430", "xl430", "xl430"), ("mx64", "mx64", "xm430", "xl430"))}}
GROUPS = (("coulomb_friction", "viscous_friction", "stribeck_friction", "load_friction", "transmission_hysteresis"), ("dead_time", "drive_lag"),
          ("backlash", "joint_elasticity", "rotor_inertia", "joint_spring", "joint_stop"), ("payload", "link_mass", "tilted_base", "encoder_offset"),
          ("saturation",), ("encoder_gain",))  # a pair comes from two of them
CAUSES = tuple(c for group in GROUPS for c in group)
OUTSIDE = ("dead_band", "integral_action", "voltage_sag", "thermal_derating", "target_rate_limit", "wind", "hose_pull", "lost_commands")
SHARED = (*GROUPS[0], *(ALIKE := (*GROUPS[1], "rotor_inertia")))  # on one joint or on all, these three with one number
AT = {  # the joints where a cause is neither the same as another one nor nothing at all; other arms are not used for it
    "encoder_offset": {"desk": [1], "desktop": [1, 2]}, "encoder_gain": {"stand": [0], "desk": [0, 1], "desktop": [1, 2]},
    "link_mass": {"desk": [0], "desktop": [1, 2]}, "payload": {"desk": [0], "desktop": [0]}, "tilted_base": {"desktop": [0]}}
SIZES = {  # the least small and the most large one (the levels are fifths of the way in logarithms); others: their share of a joint's usual torque
    "load_friction": (0.1, 0.6), "rotor_inertia": (0.25, 1.8), "link_mass": (0.12, 1.1), "encoder_gain": (0.03, 0.25),  # of what they add to
    "backlash": (0.008, 0.08), "encoder_offset": (0.04, 0.3), "dead_band": (0.008, 0.07), "tilted_base": (2, 16),  # rad; degrees
    "dead_time": (0.01, 0.1), "drive_lag": (0.012, 0.12), "integral_action": (0.3, 5), "payload": (0.1, 1.1),  # s; 1/s; of the rated payload
    "joint_stop": (0.04, 0.28), "target_rate_limit": (0.04, 0.4), "lost_commands": (0.02, 0.25),  # of the time
    "joint_elasticity": (0.2, 0.75), "saturation": (0.3, 1.0), "voltage_sag": (0.06, 0.4), "thermal_derating": (0.08, 0.6)}  # of the servo's
SEEN = {"small": (0.03, 0.4), "medium": (0.06, 1.3), "large": (0.12, 12)}  # how far the angles change, in the usual error (target - angle)

def bodies(robot, rng):
    """An arm of this kind as a URDF tree, its servos' models and their numbers (rows as in SERVOS)."""
    kind, root, parent, at = ARMS[robot], ET.fromstring(f'<robot name="{robot}"><link name="base"/></robot>'), "base", np.array((0, 0, 0.12))
    servos = list(kind["servos"][int(rng.integers(len(kind["servos"])))])
    models = {k: np.array(x) * rng.uniform(0.85, 1.15, 4) for k, x in SERVOS.items()}  # a gain set by the user, a supply of its own, ...
    long, heavy, tip = rng.uniform((0.85, 0.85, 0.6), (1.2, 1.2, 1.5))
    for link, joint, axis, towards, length, mass in [*kind["links"], ("tip", "tip_joint", "", (0, 0, 0), 0, tip * kind["tip"])]:
        d, mass, length = np.array(towards), mass * heavy * rng.uniform(0.9, 1.1), length * long
        tensor = _text(*(mass * (2e-4 + length**2 / 12 * (1 - d * d)))).split()
        ends = f'<origin xyz="{_text(*at)}" rpy="0 0 0"/><parent link="{parent}"/><child link="{link}"/>'
        turns = f'<axis xyz="{axis}"/><limit lower="-3.14" upper="3.14" effort="8" velocity="8"/>' if axis else ""
        root.extend(ET.fromstring(f"""<x><link name="{link}"><inertial><origin xyz="{_text(*(0.6 * length * d))}" rpy="0 0 0"/><mass value="{_text(mass)}"/>
            <inertia ixx="{tensor[0]}" iyy="{tensor[1]}" izz="{tensor[2]}" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <joint name="{joint}" type="{"revolute" if axis else "fixed"}">{ends}{turns}</joint></x>"""))
        parent, at = link, length * d
    return root, servos, np.array([models[k] for k in servos]).T.round(4)

def targets(kind, rng, t, home, room):
    """The commands of one trial: a row per time, a column per joint."""
    n, end = len(home), t[-1]
    size = room * rng.uniform(0.5, 1.0, n) * np.where(rng.random(n) < (0.85 if n > 1 else 1), 1, 0.03)  # some joints nearly rest
    center, s, phase = home + 0.15 * room * rng.uniform(-1, 1, n), t[:, None], rng.uniform(0, 6.28, (3, 1, n))
    if kind == "sines":
        f, part = rng.uniform((0.1, 0.3, 0.8), (0.3, 0.8, 1.6), (n, 1, 3)).T, rng.uniform(0.4, 1, (3, 1, n)) * size / 1.6
        parts = np.minimum(part, rng.uniform(0.9, 1.8) / (2 * np.pi * f)) * np.sin(2 * np.pi * f * s + phase)
        return center + parts.sum(0) * np.clip(s / 0.8, 0, 1)
    if kind == "chirp":
        f = 0.2 * np.exp((rate := math.log(rng.uniform(2.5, 5) / 0.2) / end) * s)
        return center + np.minimum(size, rng.uniform(1.2, 2) / (2 * np.pi * f)) * np.sin(2 * np.pi * (f - 0.2) / rate) * rng.choice([-1, 1], n)
    if kind == "ramps": return center + size * 2 / np.pi * np.arcsin(np.sin(np.pi / 2 * rng.uniform(0.08, 0.4, n) / np.maximum(size, 0.05) * s))
    if kind == "lifts":  # up, a rest, down, a rest: all joints at once
        rest = rng.uniform(0.1, 0.3)
        x = np.clip((1 - np.abs(s / rng.uniform(2.5, 5) % 1 * 2 - 1) - rest / 2) / (1 - rest), 0, 1)
        return center - size * rng.choice([-1, 1], n) * np.cos(np.pi * x)
    low, high, ramp, jump = (0.5, 1.4, TINY, 0.5) if kind == "steps" else (1.5, 3.0, rng.uniform(0.3, 0.8), 1.5)  # or holds
    out = np.tile(center, (len(t), 1))
    for j, begin in [(j, x) for j in range(n) for x in np.arange(0.4, end, high)]:
        new = out[-1, j] + rng.uniform(0.3, 1) * min(jump, 2 * size[j]) * rng.choice([-1, 1])
        new = 2 * np.clip(new, center[j] - size[j], center[j] + size[j]) - new  # back from the end of the room
        x = np.clip((t - begin - rng.uniform(0, high - low)) / ramp, 0, 1)
        out[:, j] += (new - out[-1, j]) * (3 - 2 * x) * x * x
    return out

def draw(seed, causes=None, level=None):
    """The hidden case of this seed, all but the sizes of its causes (`causes` and `level` force the choice)."""
    import mujoco
    rng, dice = (np.random.default_rng([seed, k]) for k in (0, 1))
    kind = str(rng.choice(["single", "pair", "none", "outside"], p=[0.55, 0.15, 0.15, 0.15]))
    if causes is None:
        pools = {"outside": [OUTSIDE], "none": [], "pair": [GROUPS[g] for g in rng.choice(len(GROUPS), 2, False, np.array([5, 2, 5, 4, 1, 1]) / 18)]}
        causes = [str(rng.choice(pool)) for pool in pools.get(kind, [CAUSES])]
    else:
        causes = [causes] if isinstance(causes, str) else list(causes)
        kind = "outside" if set(causes) & set(OUTSIDE) else ("none", "single", "pair")[len(causes)]
    levels = [level or str(rng.choice(LEVELS, p=[0.25, 0.45, 0.3] if kind == "single" else [0, 0.55, 0.45])) for _ in causes]
    able = [r for r in ARMS if all(r in AT.get(c, ARMS) for c in causes)]
    root, servos, numbers = bodies(robot := able[int(dice.random() * len(able))], dice)
    home, room, n, count = np.array(ARMS[robot]["home"]), np.array(ARMS[robot]["room"]), len(servos), int(dice.integers(4, 7))
    res, rate = 2 * math.pi / int(dice.choice([4096, 4096, 4096, 8192, 16384])), int(dice.choice([100, 125, 200, 250]))
    kinds = ["sines", *dice.permutation(["steps", "chirp"]), *dice.permutation(["sines", "steps", "ramps", "lifts", "holds"])]
    trials, off, kinds = [], dice.random() < 0.25, [str(k) for k in np.delete(kinds, 2)[:count]]
    for i, k in enumerate(kinds):
        t = np.arange(round(dice.uniform(6, 12) * rate)) / rate
        sent, gone = np.round(targets(k, dice, t, home, room) / res) * res, rate * (dice.uniform(1, 2) if n == 1 else dice.uniform(0.4, 0.7))
        trials.append({"kind": k, "t": t, "sent": sent, "on": len(t) - round(gone) * (off and i == count - 2)})
    m, q, a, one = _spec(root).compile(), home + room * dice.uniform(-1, 1, (300, n)), dice.normal(0, 4, (300, n)), np.eye(n)
    m.dof_armature[:], data = numbers[3], mujoco.MjData(m)
    gravity, usual = inverse(m, data, q, 0 * q, 0 * q), np.maximum(rms(inverse(m, data, q, 0 * q, a)), 6 * res * numbers[0])  # N m
    inertia = np.diag(np.subtract(*(inverse(m, data, home + 0 * one, 0 * one, x * one) for x in (1, 0))))
    guessed, untold, roughly, late, slow_clock, degrees = (dice.random(6) < (0.5, 0.25, 0.5, 0.3, 0.2, 0.3)).tolist()
    guessed &= not {"saturation", "viscous_friction"} & set(causes)  # with guessed numbers these would be no faults
    factors = np.exp(dice.uniform(math.log(0.6), math.log(1.6), (3, 1))) if guessed else 1 + dice.uniform(-0.03, 0.03, (3, n))
    rubs = dice.uniform(0.02, 0.05, (2, n)) * usual * [["coulomb_friction" not in causes], [2 * ("viscous_friction" not in causes)]]
    rotor, bus = numbers[3] * (1 + dice.uniform(-0.03, 0.03, n)), round(dice.uniform(1e-3, 3e-3) / STEP) * (late and "dead_time" not in causes)
    return dict(seed=int(seed), kind=kind, causes=causes, levels=levels, robot=robot, root=root, numbers=numbers, servos=servos, home=home, rate=rate,
                trials=trials, resolution=res, usual=usual, gravity=np.abs(gravity).max(0), inertia=inertia, guessed=guessed, rubs=rubs, bus=bus,
                declared=numbers[:3] * factors, rotor=rotor * ("rotor_inertia" in causes or not untold), roughly=roughly,
                moving=[x[1] for x in ARMS[robot]["links"]], ms=slow_clock, deg=degrees)

def size(cause, level, rng, case, q, tau, boost):
    """The parameters of one cause at this level (times `boost`), and the joints that it sits on; q and tau: without causes."""
    names, robot, usual, (k, damp, _, rotor), n = case["moving"], case["robot"], case["usual"], case["numbers"], len(case["moving"])
    (low, high), part, sign, v = SIZES.get(cause, (0.12, 0.9)), LEVELS.index(level) * 0.4, rng.choice([-1.0, 1.0]), rng.random()
    at, every, one, peak = rng.uniform(0, 2 * math.pi), cause in SHARED and rng.random() < 0.45, np.ones(n), np.abs(tau).max(0)
    u = np.minimum(boost * low * (high / low) ** rng.uniform(part, part + 0.2, n if every and cause not in ALIKE else 1), 1.25 * high) * one
    floor = np.maximum((0.8 if robot == "stand" else 1.1) * case["gravity"], 0.4 * rms(tau))  # a weaker servo could not hold the arm
    own, crossing = 1 - rotor / case["inertia"], np.abs(np.diff(np.sign(tau), axis=0)).mean(0)
    fit = {"saturation": peak > 1.5 * floor, "backlash": crossing, "rotor_inertia": 1 - own, "joint_elasticity": own}.get(cause, one) + 1e-3
    fit = np.where(np.isin(np.arange(n), AT.get(cause, {}).get(robot, np.arange(n))), fit, -1) * np.where(np.ptp(q, axis=0) > 0.5, 1, 0.1)
    j, form = int(rng.choice(np.flatnonzero(fit >= 0.6 * fit.max()))), "lag" if v < 0.4 else "slow"
    u0, fast = float(u[0]), np.concatenate([np.abs(np.diff(r["sent"], axis=0)).max(1) * case["rate"] for r in case["trials"] if r["kind"] != "steps"])
    side, post, push = [math.cos(at), math.sin(at), 0] if robot == "desktop" else [sign, 0, 0], (0.25, 0, 0.35) + rng.uniform(-0.2, 0.2, 3), 4 * usual.max()
    lean, stop = math.radians(u0), float(np.quantile(q[:, j], np.clip(1 - u0 if sign > 0 else u0, 0, 1)))
    values = {  # of each joint; a lag of the torque has to stay short, or the servo swings
        "viscous_friction": u * usual / 0.5, "rotor_inertia": (u if sign > 0 or boost > 1.5 else -np.minimum(0.9, u / 2)) * rotor,
        "drive_lag": np.minimum(12 * u, 0.75) * damp / k if form == "lag" else u, "saturation": np.maximum(floor, peak ** (1 - u) * floor**u),
        "encoder_offset": sign * u, "encoder_gain": 1 + sign * u, "load_friction": u, "dead_time": u}.get(cause, u * usual)
    out = {"drive_lag": {"form": form}, "stribeck_friction": {"speed": 0.05 + 0.15 * v}, "transmission_hysteresis": {"angle": 0.05 + 0.1 * v},
           "backlash": {"range": [-u0 / 2, u0 / 2], "time_constant": 0.004}, "joint_elasticity": {"stiffness": k[j] / u0, "damping": 0.02 * damp[j]},
           "joint_stop": {"range": [-20, stop] if sign > 0 else [stop, 20], "time_constant": 0.01 + 0.02 * v},
           "joint_spring": {"stiffness": u0 * usual[j] / 0.4, "rest": case["home"][j] + 0.5 * sign * v},
           "payload": {"mass": u0 * ARMS[robot]["rated"], "offset": rng.uniform(-0.02, 0.02, 3)}, "integral_action": {"rate": u0},
           "link_mass": {"link": ARMS[robot]["links"][j][0], "factor": 1 + u0 if sign > 0 or u0 > 0.8 else 1 / (1 + u0)}, "dead_band": {"size": u0},
           "tilted_base": {"degrees": u0, "gravity": 9.81 * np.array([math.sin(lean) * math.cos(at), math.sin(lean) * math.sin(at), -math.cos(lean)])},
           "thermal_derating": {"lost": u0, "time": 8 + 12 * v}, "hose_pull": {"stiffness": u0 * push / 0.3, "point": post}, "voltage_sag": {"lost": u0},
           "target_rate_limit": {"speed": np.quantile(fast, max(0, 1 - u0))}, "wind": {"force": u0 * push, "pulse": 2 + 4 * v, "towards": side},
           "lost_commands": {"share": u0, "longest": round((0.05 + 0.1 * v) * case["rate"])}}.get(cause, {})
    on = [] if cause in (*OUTSIDE, "payload", "link_mass", "tilted_base") else names if every else [names[j]]
    if cause in (*SHARED, "saturation", "encoder_offset", "encoder_gain"):
        out["values"] = {i: float(values[names.index(i)]) for i in on}
    return json.loads(json.dumps({"level": level, **out}, default=lambda x: x.tolist())), list(on)

class Plant:
    """The arm as it really is, with these causes (name -> parameters) on these joints (name -> list)."""

    def __init__(self, case, p, on):
        """Put every cause where MuJoCo has it; the rest becomes a function that is called before each step."""
        import mujoco
        names, n, root, flexed = case["moving"], len(case["moving"]), case["root"], [on[c][0] for c in ("backlash", "joint_elasticity") if c in p]
        self.case, self.p, self.before, self.gain, self.heat, self.now = case, p, [], np.ones(n), np.zeros(n), 0.0
        self.numbers, self.offset, self.lag, self.slow, self.late = case["numbers"].copy(), *np.zeros((3, n)), np.full(n, case["bus"])
        for name in flexed: root = split(root, name, 0.01)  # next to nothing is left on the motor's side: there is the rotor
        tip = (spec := _spec(root)).body("tip")
        for k in names: spec.add_actuator(name=k, target=k, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        if x := p.get("payload"): tip.add_body(name="payload", pos=x["offset"], mass=x["mass"], inertia=[x["mass"] * 3e-4] * 3, explicitinertial=True)
        if x := p.get("hose_pull"):
            hose = spec.add_tendon(name="hose", stiffness=[x["stiffness"], 0, 0], springlength=[0, 0])
            spec.worldbody.add_site(name="post", pos=x["point"]), tip.add_site(name="clip"), hose.wrap_site("post"), hose.wrap_site("clip")
        self.model = m = spec.compile()
        self.data, self.tip, self.dof = mujoco.MjData(m), m.body("tip").id, np.array([m.joint(k).dofadr[0] for k in names])
        self.flex = [(names.index(k), m.joint(k + "_flex").dofadr[0]) for k in flexed]  # of the output; all are hinges: qpos is indexed like qvel
        m.dof_solref[:], m.dof_solimp[:] = (2 * STEP, 1), (0.9995, 0.9995, 0.001, 0.5, 2)  # friction that sticks well
        m.dof_armature[self.dof], m.dof_frictionloss[self.dof], m.dof_damping[self.dof] = self.numbers[3], *case["rubs"]
        for cause, x in p.items():
            for j in [names.index(k) for k in on[cause]] or [0]:
                self._set(cause, x, x.get("values", {}).get(names[j], 0.0), j, m, int(self.dof[j]))
        mujoco.mj_setConst(m, self.data)
        self.loss = m.dof_frictionloss.copy()

    def _set(self, cause, x, value, j, m, dof):
        """Set what can be set in the compiled model and in the servo; for the rest, add a function to call each step."""
        d, state, i = self.data, [0.0], next((m.dof_jntid[f] for k, f in self.flex if cause in ("backlash", "joint_elasticity")), m.dof_jntid[dof])
        def load():  # friction by the mean of what goes into the gear and what comes out of it
            out = d.qfrc_actuator[dof] + d.qfrc_passive[dof] + d.qfrc_constraint[dof] - m.dof_armature[dof] * d.qacc[dof]
            state[0] += 0.1 * (0.5 * (d.ctrl[j] + out) - state[0])
            return value * abs(state[0])
        def dahl():  # torque that builds up over an angle, and over as much again after each turn
            step = d.qvel[dof] * STEP / x["angle"]
            state[0] = min(value, max(-value, state[0] + value * step - abs(step) * state[0]))
            return -state[0]
        adds = {"coulomb_friction": m.dof_frictionloss, "viscous_friction": m.dof_damping, "rotor_inertia": m.dof_armature}
        sets = {"saturation": self.numbers[2], "encoder_offset": self.offset, "encoder_gain": self.gain, "drive_lag": getattr(self, x.get("form", "lag"))}
        calls = {"load_friction": (m.dof_frictionloss, dof, load), "transmission_hysteresis": (d.qfrc_applied, dof, dahl),
                 "stribeck_friction": (m.dof_frictionloss, dof, lambda: value * (0.4 + math.exp(-((d.qvel[dof] / x["speed"]) ** 2)))),
                 "wind": (d.xfrc_applied[self.tip], slice(3), lambda: x["force"] * np.array(x["towards"]) * (0.4 + math.sin(x["pulse"] * (self.now + d.time))))}
        if cause in adds: adds[cause][dof] += value
        elif cause in sets: sets[cause][j] = value
        elif cause in calls: self.before.append(calls[cause])
        elif cause == "dead_time": self.late[j] += round(value / STEP)
        elif cause == "tilted_base": m.opt.gravity[:] = x["gravity"]
        elif cause == "link_mass":
            for b in (b for b in range(m.nbody) if m.body(b).name.removesuffix("_motor") == x["link"]):
                m.body_mass[b], m.body_inertia[b] = x["factor"] * m.body_mass[b], x["factor"] * m.body_inertia[b]
        elif "stiffness" in x and cause != "hose_pull":
            m.jnt_stiffness[i], m.qpos_spring[m.jnt_qposadr[i]] = x["stiffness"], x.get("rest", 0)
            m.dof_damping[m.jnt_dofadr[i]] += x.get("damping", 0)
        elif "range" in x:
            m.jnt_limited[i], m.jnt_range[i], m.jnt_solref[i], m.jnt_solimp[i] = 1, x["range"], (x["time_constant"], 1), (0.9, 0.99, 0.002, 0.5, 2)

    def commanded(self, i, every):
        """What the servos chase at each step of trial i: targets that are held, and perhaps lost, late, smoothed or slowed."""
        sent, rng, k = self.case["trials"][i]["sent"], np.random.default_rng([self.case["seed"], 3, i]), len(self.case["trials"][i]["sent"])
        if x := self.p.get("lost_commands"):
            sent = sent.copy()
            for at in 1 + np.flatnonzero(rng.random(k - 1) < 2 * x["share"] / (1 + x["longest"])):
                sent[at : at + int(rng.integers(1, x["longest"] + 1))] = sent[at - 1]
        row = (np.arange(-SETTLE, k * every)[:, None] - self.late) // every
        goal = np.take_along_axis(sent, np.clip(row, 0, k - 1), 0)
        part, most = 1 - np.exp(-STEP / np.maximum(self.slow, TINY)), STEP * self.p.get("target_rate_limit", {}).get("speed", math.inf)
        for s in range(1, len(goal) if self.slow.any() or most < math.inf else 0):
            goal[s] = goal[s - 1] + np.clip(part * (goal[s] - goal[s - 1]), -most, most)
        return goal

    def run(self, i):
        """Trial i: the encoders' angles at its rows, and the servos' torques then."""
        import mujoco
        m, d, case, trial, res, get = self.model, self.data, self.case, self.case["trials"][i], self.case["resolution"], self.p.get
        every, rows, total = round(1 / case["rate"] / STEP), [], sum(r["t"][-1] for r in case["trials"])
        goal, (k, damp, limit, _), lags = self.commanded(i, every), self.numbers, self.lag.any()
        keep, gone, power = np.exp(-STEP / np.maximum(self.lag, TINY)), SETTLE + trial["on"] * every, 1.0
        self.now, summed, late = sum(r["t"][-1] for r in case["trials"][:i]), *np.zeros((2, len(k)))
        band, rate, sag, warm = get("dead_band"), get("integral_action"), get("voltage_sag"), get("thermal_derating")
        mujoco.mj_resetData(m, d)
        d.qpos[self.dof] = (goal[0] - self.offset) / self.gain
        for s, aim in enumerate(goal):
            angle = d.qpos[self.dof]
            for j, f in self.flex: angle[j] += d.qpos[f]
            seen, pull = np.round((self.gain * angle + self.offset) / res) * res, damp * d.qvel[self.dof]
            error = aim - seen
            if band: error *= np.abs(error) > band["size"]
            push = k * error
            if rate: push = push + (summed := np.clip(summed + rate["rate"] * STEP * push, -0.4 * limit, 0.4 * limit))
            if sag: power = 1 - sag["lost"] * (self.now + d.time) / total
            if warm: pull = pull * (power := 1 - warm["lost"] * np.minimum(1, self.heat))
            tau = np.minimum(np.maximum(power * push - pull, -power * limit), power * limit)
            if warm: self.heat += STEP / warm["time"] * ((tau / case["usual"]) ** 2 - self.heat)
            if lags: late = tau = tau + keep * (late - tau)
            if s >= gone: tau = 0 * tau
            if s >= SETTLE and (s - SETTLE) % every == 0: rows.append((seen, tau))
            d.ctrl[:], m.dof_frictionloss[:], d.qfrc_applied[:], d.xfrc_applied[:] = tau, self.loss, 0, 0
            for where, dof, value in self.before: where[dof] += value()
            mujoco.mj_step(m, d)
        return np.array(rows).transpose(1, 0, 2)

def record(folder: pathlib.Path, seed: int, causes: list[str] | None = None, level: str | None = None, name: str | None = None) -> dict:
    """Draw the case of this seed, simulate it, write the recordings into the folder and return the answer."""
    case, folder, name, p, on = draw(seed, causes, level), pathlib.Path(folder), name or f"case-{seed}", {}, {}
    trials, moving, numbers, last = case["trials"], case["moving"], case["numbers"], len(case["trials"]) - 1
    base = [Plant(case, p, on).run(i) for i in range(last + 1)]
    q, tau = (np.concatenate([b[x][: r["on"]] for b, r in zip(base, trials)]) for x in (0, 1))
    error = rms(np.concatenate([r["sent"][: r["on"]] for r in trials]) - q)
    def apart(plant, which):  # trials, and how far their angles are from those without causes, in the usual error
        logs = [plant.run(i) for i in which]
        off = np.concatenate([x[0][: trials[i]["on"]] - base[i][0][: trials[i]["on"]] for x, i in zip(logs, which)])
        return logs, (rms(off) / error).round(3).tolist()
    for i, (cause, how) in enumerate(zip(case["causes"], case["levels"])):
        rng, boost = np.random.default_rng([seed, 2, i]), 1.0
        for _ in range(6):  # neither too weak to be seen nor so strong that the arm runs away
            p[cause], on[cause] = size(cause, how, rng, case, q, tau, boost)
            change = max(apart(Plant(case, {cause: p[cause]}, on), (0, 1, last) if cause in OUTSIDE else (0, 1))[1])
            if SEEN[how][0] <= change < SEEN[how][1]: break
            boost *= 1.4 if change < SEEN[how][0] else 0.6
    logs, change = apart(Plant(case, p, on), range(last + 1)) if p else (base, [0.0] * len(moving))
    declared, changed = misdeclare(case["root"], seed) if case["roughly"] else (case["root"], {})
    folder.mkdir(parents=True, exist_ok=True)
    ET.indent(declared)
    ET.ElementTree(declared).write(folder / "robot.urdf", encoding="utf-8", xml_declaration=True)
    names, unit = [[f"{x}{i + 1}" for i in range(len(moving))] for x in ("q", "target")], 180 / math.pi if case["deg"] else 1
    for i, (r, log) in enumerate(zip(trials, logs), 1):
        rows = [[f"{t * (1000 if case['ms'] else 1):.9g}", *(f"{x * unit:.6f}" for x in seen), *(f"{x * unit:.6f}" if k < r["on"] else "" for x in sent)]
                for k, (t, seen, sent) in enumerate(zip(r["t"], log[0], r["sent"]))]
        (folder / f"trial_{i:02d}.csv").write_text("\n".join(map(",".join, [["t", *names[0], *names[1]], *rows])) + "\n")
    table = [f"{k} = {[float(f'{y:.4g}') for y in x]}\n" for k, x in zip("stiffness damping limit rotor_inertia".split(), (*case["declared"], case["rotor"]))]
    servo, rotor = "".join(table[:3]) + "guessed = true\n" * case["guessed"], table[3] * bool(case["rotor"].any())
    units = f'[units]\ntime = "{"ms" if case["ms"] else "s"}"\nposition = "{"deg" if case["deg"] else "rad"}"\n\n' if case["ms"] or case["deg"] else ""
    (folder / "robot.toml").write_text(f'name = "{name}"\nurdf = "robot.urdf"\njoints = {json.dumps(moving)}\n{rotor}torque_held = true\n\n[channels]\n'
        f'time = "t"\nposition = {json.dumps(names[0])}\ntarget = {json.dumps(names[1])}\n\n{units}[servo]\n{servo}')
    weaker = (case["declared"][2] > 1.04 * numbers[2]) & (np.abs(tau).max(0) > 0.999 * numbers[2])  # than declared, and it shows
    slight = {"rotor_inertia": not rotor, "dead_time": case["bus"] > 0, "link_mass": case["roughly"], "saturation": bool(weaker.any())}
    slight = {k: True for k, x in ({"coulomb_friction": True, "viscous_friction": True} | slight).items() if x and k not in p}
    facts = {"nominal_numbers": changed, "servo": {k: case[k].tolist() for k in ("numbers", "declared", "rubs")} | {"guessed": case["guessed"]},
             "bus_delay_s": case["bus"] * STEP, "counts": round(2 * math.pi / case["resolution"]), "rate_hz": case["rate"], "servos": case["servos"]}
    figures = {"change": dict(zip(moving, change)), "following_error": error.round(4).tolist(), "trials": [r["kind"] for r in trials]}
    return {"name": name, "seed": int(seed), "kind": case["kind"], "causes": case["causes"], "parameters": p, "nuisance": slight | facts,
            "joints": [k for k in moving if any(k in x for x in on.values())], "robot": case["robot"], "moving": moving, "figures": figures}
