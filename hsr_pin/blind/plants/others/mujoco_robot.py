"""A plant that nobody told the tool about: a real arm, simulated by MuJoCo, with one hidden fault.

The arms come from the package example-robot-data.  A case keeps 3 to 6 of an arm's joints, fixes the others,
hides a cause in the MuJoCo model (or in the encoder, or in the clock), lets a joint controller that knows only
the nominal bodies drive the arm, and writes what a user would have: robot.urdf, robot.toml and trial_NN.csv.
Row k has the encoders' q at t_k and the command tau worked out from it, which the drives hold until t_(k+1).
"""

import copy, importlib.metadata, json, math, pathlib, sys  # noqa: E401
import xml.etree.ElementTree as ET

import numpy as np

STEP, GRID, PREROLL, TINY = 5e-4, 1e-3, 1.0, 1e-9  # s of the simulation, of the reference motions, of standing still before the log
ROBOTS = {  # file, tip link, home posture, rated payload in kg
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "ee_link", (0, -1.0, 1.2, -0.6, 0.8, 0), 5.0),
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand", (0, -0.4, 0.2, -1.8, 0.3, 1.8, 0.5), 3.0),
    "jaco": ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", (0.3, 2.6, 1.9, 0.5, 2.0, 0.4), 1.6),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "link7", (0, -0.4, 0.2, 1.2, 0.3, 0.9, 0.2), 3.5),
    "z1": ("z1_description/urdf/z1.urdf", "link06", (0, 1.4, -1.3, 0.2, 0.2, 0.3), 2.0),
}
SHARED = ("coulomb_friction", "viscous_friction", "stribeck_friction", "load_friction", "rotor_inertia", "torque_gain",
          "torque_bias", "torque_ripple", "dead_time", "drive_lag")  # fmt: skip  # on one joint, several or all
CAUSES = (*SHARED, "saturation", "encoder_offset", "encoder_gain", "payload", "link_mass", "tilted_base", "joint_spring",
          "joint_stop", "backlash", "joint_elasticity")  # fmt: skip
LONE = ("quadratic_drag", "one_way_friction", "drifting_torque_constant", "warming_friction", "intermittent_brake")
OUTSIDE = (*LONE, "wind_gusts", "hose_pull", "coupled_cogging", "lost_encoder_samples", "swinging_load",
           "torque_crosstalk", "encoder_eccentricity", "clock_skew")  # fmt: skip
PLAIN = ("load_friction", "torque_gain", "dead_time", "drive_lag", "drifting_torque_constant")  # sized by a plain number
LEVELS, SHARE = ("small", "medium", "large"), (0.03, 0.06, 0.10, 0.18, 0.25, 0.38)  # of a joint's torque (rms): the ranges for small, medium and large
SIZES = {  # of the causes that are not sized by their share of the torque
    "rotor_inertia": (0.05, 0.1, 0.2, 0.35, 0.5, 1.0),  # of the joint's inertia
    "dead_time": (0.006, 0.01, 0.014, 0.022, 0.026, 0.036), "drive_lag": (0.007, 0.011, 0.018, 0.028, 0.036, 0.05),  # s
    "saturation": (0.95, 0.97, 0.87, 0.92, 0.75, 0.83),  # the quantile of the torque's size that is still reached
    "encoder_gain": (0.015, 0.03, 0.05, 0.09, 0.12, 0.18), "payload": (0.05, 0.1, 0.2, 0.35, 0.5, 0.9),  # of the rated payload
    "tilted_base": (1, 2, 3, 5.5, 7, 12),  # degrees
    "joint_stop": (0.04, 0.06, 0.1, 0.15, 0.2, 0.28),  # the share of the time that the motions want to be beyond it
    "backlash": (0.006, 0.012, 0.02, 0.035, 0.05, 0.08), "joint_elasticity": (8, 11, 4.5, 6.5, 2.8, 3.8),  # rad; Hz, motor held
}  # fmt: skip

def _numbers(element, key):
    return np.array([float(x) for x in (element.get(key) or "0 0 0").split()])

def _text(*values):
    return " ".join(f"{v:.9g}" for v in values)

def _description(robot):
    """The arm's URDF, and the names of its own moving joints from base to tip."""
    here = importlib.metadata.distribution("example-robot-data")
    root = ET.parse(here.locate_file("cmeel.prefix/share/example-robot-data/robots/" + ROBOTS[robot][0])).getroot()
    able = [j.get("name") for j in root.findall("joint") if j.get("type") in ("revolute", "continuous")]
    return root, able[: len(ROBOTS[robot][2])]

def _joint(name, kind, parent, child, turn="0 0 0"):
    """A joint of a URDF that lies at its parent's origin."""
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return ET.fromstring(f'<joint name="{name}" type="{kind}"><origin xyz="0 0 0" rpy="{turn}"/>{ends}</joint>')

def bodies(robot, moving, tool=None):
    """The arm's links and joints without shapes; joints that are not in `moving` are fixed at home."""
    source, names = _description(robot)
    home, root = dict(zip(names, ROBOTS[robot][2])), ET.Element("robot", name=robot)
    for old in source.findall("link"):
        ET.SubElement(root, "link", name=old.get("name")).extend(copy.deepcopy(old.findall("inertial")))
    for old in source.findall("joint"):
        name, still = old.get("name"), old.get("type") == "fixed" or old.get("name") not in moving
        new = ET.SubElement(root, "joint", name=name, type="fixed" if still else "revolute")
        for tag in ("origin", "parent", "child", "axis", "limit")[: 3 if still else 5]:
            new.extend(copy.deepcopy(old.findall(tag)))
        if old.get("type") == "continuous" and not still:
            new.find("limit").attrib.update(lower="-6.28", upper="6.28")
        if home.get(name) and still:  # a second fixed joint makes the turn (all these axes lie along x, y or z)
            dummy = ET.SubElement(root, "link", name=name + "_fixed").get("name")
            turn = _text(*(home[name] * _numbers(old.find("axis"), "xyz")))
            root.append(_joint(name + "_home", "fixed", dummy, old.find("child").get("link"), turn))
            new.find("child").set("link", dummy)
    if tool:
        i, link = _text(tool["mass"] * 0.05**2), ET.SubElement(root, "link", name="tool")
        link.append(ET.fromstring(f"""<inertial><origin xyz="{_text(*tool["center"])}" rpy="0 0 0"/><mass value="{_text(tool["mass"])}"/>
            <inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>"""))
        root.append(_joint("tool_joint", "fixed", ROBOTS[robot][1], "tool"))
    return root

def _scale(inertial, mass, inertia, shift=(0, 0, 0)):
    """Multiply a link's mass and inertia and shift its centre of mass."""
    inertial.find("mass").set("value", _text(mass * float(inertial.find("mass").get("value"))))
    tensor, origin = inertial.find("inertia"), inertial.find("origin")
    tensor.attrib.update({k: _text(inertia * float(v)) for k, v in tensor.items()})
    if origin is None:
        origin = ET.SubElement(inertial, "origin", rpy="0 0 0")
    origin.set("xyz", _text(*(_numbers(origin, "xyz") + shift)))

def misdeclare(root, seed):
    """The nominal bodies with numbers a few percent off: returns them and what was changed."""
    rng, root, changed = np.random.default_rng([seed, 2]), copy.deepcopy(root), {}
    for link in root.findall("link[inertial]"):
        mass, inertia = (1 + np.clip(rng.normal(0, 0.015, 2), -0.03, 0.03)).round(4).tolist()
        shift = np.clip(rng.normal(0, 0.0015, 3), -0.003, 0.003).round(5).tolist()
        _scale(link.find("inertial"), mass, inertia, shift)
        changed[link.get("name")] = {"mass": mass, "inertia": inertia, "shift_m": shift}
    return root, changed

def split(root, joint_name, share):
    """Cut a link in two collinear bodies: its motor side keeps `share` of it; a joint NAME_flex lies between."""
    root = copy.deepcopy(root)
    joint = root.find(f"joint[@name='{joint_name}']")
    child = joint.find("child").get("link")
    link, motor = root.find(f"link[@name='{child}']"), ET.SubElement(root, "link", name=child + "_motor")
    motor.append(copy.deepcopy(link.find("inertial")))
    _scale(motor.find("inertial"), share, share)
    _scale(link.find("inertial"), 1 - share, 1 - share)
    joint.find("child").set("link", child + "_motor")
    flex = _joint(joint_name + "_flex", "revolute", child + "_motor", child)
    flex.extend([copy.deepcopy(joint.find("axis")), ET.Element("limit", lower="-1", upper="1", effort="0", velocity="0")])
    root.append(flex)
    return root

def _spec(root):
    """A MuJoCo model in the making, from a URDF tree, without limits."""
    import mujoco
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    spec.compiler.fusestatic, spec.option.timestep = False, STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for joint in spec.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    return spec

def inverse(model, data, q, v, a):
    """MuJoCo's inverse dynamics of the rigid bodies, for rows of position, velocity and acceleration."""
    import mujoco
    out = np.empty_like(q)
    for k in range(len(q)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
        mujoco.mj_inverse(model, data)
        out[k] = data.qfrc_inverse
    return out

def _smooth(raw, width):
    """Convolve each column with a bell of this width in seconds."""
    n = max(3, int(width / GRID)) | 1
    bell = np.hanning(n + 2)[1:-1]
    padded = np.concatenate([np.repeat(raw[:1], n // 2, 0), raw, np.repeat(raw[-1:], n // 2, 0)])
    return np.stack([np.convolve(c, bell / bell.sum(), "valid") for c in padded.T], 1)

def motions(seed, home, room, count):
    """The reference motions: per trial its kind and position, velocity, acceleration on a fine grid."""
    rng, n, out = np.random.default_rng([seed, 1]), len(home), []
    kinds = ["sines", "steps", "ramps", "holds", "chirp", "sines", *rng.choice(["sines", "steps", "ramps"], 4)]
    for kind in rng.permutation(kinds[:count]):
        duration, limit, width = rng.uniform(4, 8), rng.uniform(8, 14), 0.15
        t = np.arange(-PREROLL, duration + 0.1, GRID)
        s = np.clip(t, 0, None)[:, None]
        size = 0.9 * room * rng.uniform(0.6, 1.0, n) * np.where(rng.random(n) < 0.85, 1, 0.02)  # some joints nearly rest
        center, phase = home + 0.1 * room * rng.uniform(-1, 1, n), rng.uniform(0, 6.28, (4, n))
        if kind == "sines":
            f, part = rng.uniform(0.15, 1.3, (4, n)), rng.uniform(0.3, 1, (4, n))
            raw = sum(part[k] * np.sin(2 * np.pi * f[k] * s + phase[k]) for k in range(4)) * np.clip(s / 0.8, 0, 1)
            raw = raw / np.abs(raw).max(0)
        elif kind == "chirp":
            rate = math.log(rng.uniform(3, 6) / 0.4) / duration
            f = 0.4 * np.exp(rate * s)
            raw = 0.5 * np.sin(2 * np.pi * (f - 0.4) / rate + phase[0]) * (0.4 / f) ** 1.5 * np.clip(s / 0.5, 0, 1)
        elif kind == "ramps":
            turns = rng.uniform(0.04, 0.3, n) / np.maximum(size, 0.05) * rng.choice([-1, 1], n)
            raw = 2 / np.pi * np.arcsin(np.sin(np.pi / 2 * turns * s))
        else:  # steps or holds: new levels after random times, reached softly
            low, high, width = (0.5, 1.1, rng.uniform(0.3, 0.5)) if kind == "steps" else (1.3, 2.4, rng.uniform(0.5, 0.9))
            raw = np.zeros((len(t), n))
            for j in range(n):
                for at in 0.3 + np.cumsum(np.r_[0, rng.uniform(low, high, 20)]):
                    raw[t >= at, j] = rng.uniform(-1, 1) if at < duration else raw[-1, j]
        q = center + _smooth(raw * size, width)
        a = np.gradient(np.gradient(q, GRID, axis=0), GRID, axis=0)
        q = q[0] + (q - q[0]) * np.minimum(1, limit / np.maximum(np.abs(a).max(0), TINY))
        v = np.gradient(q, GRID, axis=0)
        out.append({"kind": str(kind), "t": t, "duration": duration, "q": q, "v": v, "a": np.gradient(v, GRID, axis=0)})
    return out

def rms(x):
    """The root mean square of each column."""
    return np.sqrt(np.mean(np.square(x), 0))

class Survey:
    """What the reference motions ask of the arm when nothing is wrong: the yardsticks for the sizes."""

    def __init__(self, case):
        """Run MuJoCo's inverse dynamics along all reference motions."""
        import mujoco
        self.root = bodies(case["robot"], case["moving"], case["tool"])
        self.model = m = _spec(self.root).compile()
        self.data, one, self.home = mujoco.MjData(m), np.eye(m.nv), np.array(case["home"])
        self.room = np.minimum(0.9, np.abs(m.jnt_range.T - self.home).min(0) - 0.1)
        self.motions = motions(case["seed"], self.home, self.room, case["trials"])
        self.q, v, a = (np.concatenate([r[k][int(PREROLL / GRID) :: 25] for r in self.motions]) for k in "qva")
        self.tau, self.gravity = (inverse(m, self.data, self.q, x * v, x * a) for x in (1, 0))
        self.scale, self.speed, mass = rms(self.tau), rms(v), self.mass()
        lean = np.subtract(*(inverse(m, self.data, self.home + x * one, 0 * one, 0 * one) for x in (1e-3, 0)))
        self.pull = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass, 1e3 * lean.T))).max())  # 1/s, how fast the arm would fall
        self.inertia, self.free = np.diag(mass), 1 / (np.diag(mass) * np.diag(np.linalg.inv(mass)))  # free of the others' motion: 1
        off = [inverse(m, self.data, self.q + 0.05 * one[j], v, a) - self.tau for j in range(m.nv)]
        self.gradient = np.array([(rms(x) / self.scale).max() / 0.05 for x in off])  # of an encoder's offset, per rad
        self.bodies, self.heavier, self.own = [m.body(int(b)).name for b in m.jnt_bodyid], np.empty(m.nv), np.empty(m.nv)
        for j, b in enumerate(m.jnt_bodyid):  # without this link: its share of the torques and of its joint's inertia
            kept = m.body_mass[b], m.body_inertia[b].copy()
            m.body_mass[b], m.body_inertia[b] = TINY, TINY
            self.heavier[j] = (rms(inverse(m, self.data, self.q, v, a) - self.tau) / self.scale).max()
            self.own[j] = 1 - self.mass()[j, j] / self.inertia[j]
            m.body_mass[b], m.body_inertia[b] = kept
        self.mass()  # leaves the arm at home, for the causes that look at it
        tip, jac = self.data.body(ROBOTS[case["robot"]][1]), np.zeros((3, m.nv))
        mujoco.mj_jacBody(m, self.data, jac, None, tip.id)
        self.push = float(1 / np.median(np.linalg.norm(jac, axis=0) / self.scale))  # N at the tip, worth the motions' torque
        self.tip, self.down = tip.xpos.copy(), -tip.xmat.reshape(3, 3)[2]

    def mass(self):
        """The mass matrix at home."""
        one = np.eye(self.model.nv)
        return np.subtract(*(inverse(self.model, self.data, self.home + 0 * one, 0 * one, x * one) for x in (1, 0)))

def _size(cause, level, rng, case, s):
    """The parameters of one cause at this level, and the joints that it sits on."""
    names, n, sign, at = case["moving"], len(case["moving"]), rng.choice([-1.0, 1.0]), rng.uniform(0, 2 * math.pi)
    span = SIZES.get(cause, SHARE)[2 * LEVELS.index(level) :][:2]
    u, v, two = rng.uniform(*span), rng.random(), rng.choice(n, 2, replace=False)

    def best(score, least):
        """One joint whose score is at least this."""
        return int(rng.choice(np.flatnonzero(score >= least)))  # a ValueError if there is none

    if cause in (*SHARED, *LONE, "joint_spring"):
        late = cause in ("dead_time", "drive_lag")  # the same for all joints, or else the controller would go mad
        how = rng.choice([1, n if late else int(rng.integers(2, n + 1)), n], p=[0.6, 0.2, 0.2] if cause in SHARED else [1, 0, 0])
        on = sorted(rng.choice(n, int(how), replace=False).tolist())
        if late: best(np.array([-u * s.pull]), -0.2)  # or no controller could hold the arm
        on = [best(s.free if late else s.gradient, 0.5)] if (late or cause == "load_friction") and how == 1 else on
        unit = {"viscous_friction": s.scale / s.speed, "rotor_inertia": s.inertia, "joint_spring": s.scale / 0.3,
                "quadratic_drag": s.scale / s.speed**2} | dict.fromkeys(PLAIN, np.ones(n))  # fmt: skip
        values = {}
        for j in on:
            x = (u if late else rng.uniform(*span)) * unit.get(cause, s.scale)[j]
            phase = rng.uniform(0, 2 * math.pi)
            values[names[j]] = {
                "torque_gain": 1 + sign * x, "torque_bias": x if phase > 3 else -x,
                "stribeck_friction": {"coulomb": 0.5 * x, "static": 1.5 * x, "speed": 0.06 + 0.02 * phase},
                "torque_ripple": {"size": x, "per_turn": int(rng.integers(8, 31)), "phase": phase},
                "joint_spring": {"stiffness": x, "rest": case["home"][j] + 0.1 * (phase - 3)},
            }.get(cause, x)  # fmt: skip
        return {"level": level, "values": values}, list(values)
    limit = np.quantile(np.abs(s.tau), min(u, 1), axis=0)
    reverses = np.abs(np.diff(np.sign(s.tau), axis=0)).mean(0) / 2 > 0.012  # every other second
    spots = {  # where a cause shows itself: a score of the joints and the least that will do
        "saturation": (limit / (TINY + np.abs(s.gravity).max(0)), 1.2), "joint_stop": (s.speed, 0.2),
        "encoder_offset": (s.gradient, 0.4), "encoder_gain": (s.gradient * rms(s.q), 0.6), "encoder_eccentricity": (s.gradient, 0.8),
        "link_mass": (np.where(np.arange(n) < n - 1, s.heavier, 0), 0.15), "torque_crosstalk": (-s.scale, -0.99 * s.scale.max()),
        "backlash": (s.own * reverses, 0.2), "joint_elasticity": (s.own, 0.2)}  # fmt: skip
    j = best(*spots[cause]) if cause in spots else 0
    on = {"link_mass": [], "coupled_cogging": sorted(two.tolist())}.get(cause, [j] if cause in spots else [])
    giver, beyond = int(np.argmax(s.scale)), s.inertia[j] * (1 - 0.6 * s.own[j])
    point = np.array((0.2, -0.7, 0.2)) + np.array((0.5, 1.4, 1.0)) * rng.random(3)
    gravity = 9.81 * np.array([math.sin(math.radians(u)) * math.cos(at), math.sin(math.radians(u)) * math.sin(at), -math.cos(math.radians(u))])
    rated, soft = ROBOTS[case["robot"]][3], np.quantile(s.q[:, j], min(1, 1 - u if sign > 0 else u))
    out = {
        "saturation": {"limit": limit[j]}, "encoder_gain": {"gain": 1 + sign * u},
        "encoder_offset": {"offset": sign * min(0.2, u / (TINY + s.gradient[j]))}, "tilted_base": {"degrees": u, "gravity": gravity.tolist()},
        "payload": {"mass": u * rated, "offset": rng.uniform(-0.03, 0.03, 3).tolist()},
        "link_mass": {"link": s.bodies[j], "factor": 1 + min(1.0, u / s.heavier[j])},
        "joint_stop": {"stop": soft, "side": "upper" if sign > 0 else "lower", "time_constant": 0.02 + 0.03 * v},
        "backlash": {"motor_share": 0.6, "gap": u},
        "joint_elasticity": {"motor_share": 0.6, "frequency_hz": u, "stiffness": beyond * (2 * math.pi * u) ** 2,
                             "damping": (0.04 + 0.12 * v) * beyond * 2 * math.pi * u},
        "wind_gusts": {"force": 1.5 * u * s.push, "frequency_hz": 0.3 + 0.9 * v, "towards": [math.cos(at), math.sin(at)]},
        "hose_pull": {"stiffness": 2 * u * s.push / max(0.3, np.linalg.norm(s.tip - point)), "point": point.tolist()},
        "coupled_cogging": {"sizes": [2 * u * s.scale[i] for i in on], "per_turn": rng.integers(6, 20, 2).tolist()},
        "lost_encoder_samples": {"chance": 0.08 * u, "longest": int(3 + 6 * v)}, "clock_skew": {"stretch": 1 + sign * u * 0.35},
        "swinging_load": {"mass": 1.2 * u * rated, "length": 0.08 + 0.12 * v},
        "torque_crosstalk": {"from": names[giver], "factor": sign * 1.5 * u * s.scale[j] / s.scale[giver]},
        "encoder_eccentricity": {"size": min(0.1, u / (TINY + s.gradient[j])), "phase": 6.28 * v},
    }[cause]  # fmt: skip
    return {"level": level, **out}, [names[i] for i in on]

def draw(seed, causes=None, level=None):
    """The hidden case of this seed: what is wrong, how much, and how it is recorded (`causes` and `level` force the choice)."""
    rng = np.random.default_rng([seed, 0])
    kind = str(rng.choice(["single", "pair", "none", "outside"], p=[0.55, 0.15, 0.15, 0.15]))
    if causes is None:
        pool, count = OUTSIDE if kind == "outside" else CAUSES, {"pair": 2, "none": 0}.get(kind, 1)
        causes = [str(c) for c in rng.choice(pool, count, replace=False)]
        causes = ["backlash", "coulomb_friction"] if set(causes) == {"backlash", "joint_elasticity"} else causes
    else:
        kind = "outside" if set(causes) & set(OUTSIDE) else ("none", "single", "pair")[len(causes)]
    levels = [level or str(rng.choice(LEVELS, p=[0.25, 0.45, 0.3] if kind == "single" else [0, 0.55, 0.45])) for _ in causes]
    off, sticky, jitter = (rng.random(3) < (0.4, 0.5, 0.3)).tolist()
    rate = int(rng.choice([200, 250] if jitter else [200, 250, 400, 500]))
    noise = {"kind": str(rng.choice(["quantised", "white"])), "size": float(10 ** rng.uniform(-5, math.log10(5e-4)))}
    case = {"seed": int(seed), "kind": kind, "causes": causes, "trials": int(rng.integers(6, 11)), "rate": rate,
            "jitter_steps": int(jitter), "encoder": noise, "misdeclared": off}  # fmt: skip
    for attempt in range(80):  # draw the arm and its joints until the causes can show themselves
        robot = str(rng.choice(list(ROBOTS)))
        chain, center = _description(robot)[1], rng.uniform(0.03, 0.06, 3).tolist()
        pick = sorted({1, *rng.choice(len(chain), int(rng.integers(3, 7)), replace=False).tolist()})[:6]
        tool = {"mass": ROBOTS[robot][3] * rng.uniform(0.1, 0.25), "center": center}
        case |= {"robot": robot, "moving": [chain[i] for i in pick], "home": [float(ROBOTS[robot][2][i]) for i in pick],
                 "tool": tool if pick[-1] == len(chain) - 1 or rng.random() < 0.3 else None}  # fmt: skip
        survey = Survey(case)
        try:
            sized = {c: _size(c, k, rng, case, survey) for c, k in zip(causes, levels)}
            break
        except ValueError:
            if attempt == 79: raise
    late = sum(max(sized[c][0]["values"].values()) for c in ("dead_time", "drive_lag") if c in sized)
    most = 5.0 if {"backlash", "joint_elasticity"} & set(causes) else min(20.0, 0.25 / max(late, TINY))  # rad/s
    gains = np.clip(np.sqrt(10 * survey.scale / survey.inertia), min(most, 8.0), most) * rng.uniform(0.7, 1)  # weak joints: stiffer
    viscous = survey.scale / survey.speed * rng.uniform(0, 0.008, len(pick)) * sticky
    case |= {"parameters": {c: p for c, (p, _) in sized.items()}, "on": {c: j for c, (_, j) in sized.items()}}
    return json.loads(json.dumps(case | {"viscous": viscous.tolist(), "stiffness": gains.tolist()}))  # plain numbers only

class Plant:
    """The arm as it really is: a MuJoCo model with the causes in it, its encoders and its drives."""

    def __init__(self, case, survey):
        """Put every cause where MuJoCo has it; the rest becomes a function that is called before each step."""
        import mujoco
        p, names, n = case["parameters"], case["moving"], len(case["moving"])
        self.case, self.before, self.session, self.total = case, [], 0.0, sum(r["duration"] for r in survey.motions)
        self.gain, self.offset, self.wobble = np.ones(n), np.zeros(n), np.zeros((2, n))
        self.delay, self.clock, root = np.zeros(n, int), p.get("clock_skew", {}).get("stretch", 1.0), survey.root
        for cause in {"backlash", "joint_elasticity"} & set(p):
            root = split(root, case["on"][cause][0], p[cause]["motor_share"])
        tip = (spec := _spec(root)).body(ROBOTS[case["robot"]][1])
        for motor, k in [(spec.add_actuator(name=k, target=k, trntype=mujoco.mjtTrn.mjTRN_JOINT), k) for k in names]:
            if k in p.get("drive_lag", {}).get("values", {}):
                motor.dyntype, motor.dynprm = mujoco.mjtDyn.mjDYN_FILTEREXACT, [p["drive_lag"]["values"][k]] + [0] * 9
        if x := p.get("payload"):
            tip.add_body(name="payload", pos=x["offset"], mass=x["mass"], inertia=[x["mass"] * 9e-4] * 3, explicitinertial=True)
        if x := p.get("swinging_load"):  # a pendulum that hangs from the tip by a ball joint
            load = tip.add_body(name="load", mass=x["mass"], ipos=survey.down * x["length"], inertia=[x["mass"] * 4e-4] * 3, explicitinertial=True)
            load.add_joint(type=mujoco.mjtJoint.mjJNT_BALL, name="swing", damping=[0.6 * x["mass"] * x["length"] ** 1.5, 0, 0])
        if x := p.get("hose_pull"):
            spec.worldbody.add_site(name="post", pos=x["point"])
            tip.add_site(name="clip")
            hose = spec.add_tendon(name="hose", stiffness=[x["stiffness"], 0, 0], springlength=[0, 0])
            hose.wrap_site("post"), hose.wrap_site("clip")
        self.model = m = spec.compile()
        self.data, self.tip = mujoco.MjData(m), m.body(tip.name).id
        self.qadr, self.dof = (np.array([getattr(m.joint(k), f)[0] for k in names]) for f in ("qposadr", "dofadr"))
        m.dof_solref[:], m.dof_solimp[:] = (2 * STEP, 1), (0.9995, 0.9995, 0.001, 0.5, 2)  # friction that sticks well
        m.dof_damping[self.dof] = case["viscous"]
        for cause, x in p.items():
            for j in [names.index(k) for k in case["on"][cause]] or [0]:
                self._set(cause, x.get("values", {}).get(names[j], x), j, m, int(self.dof[j]), int(self.qadr[j]))
        mujoco.mj_setConst(m, self.data)
        self.loss = m.dof_frictionloss.copy()

    def _set(self, cause, x, j, m, dof, adr):
        """Set what can be set in the compiled model and in the encoders; for the rest, add a function to call each step."""
        flex = m.joint(self.case["moving"][j] + "_flex").id if cause in ("backlash", "joint_elasticity") else -1
        if cause == "coulomb_friction": m.dof_frictionloss[dof] = x
        elif cause == "viscous_friction": m.dof_damping[dof] += x
        elif cause == "rotor_inertia": m.dof_armature[dof] = x
        elif cause == "torque_gain": m.actuator_gear[j, 0] = x
        elif cause == "dead_time": self.delay[j] = round(x / STEP)
        elif cause == "torque_bias": m.actuator_biastype[j], m.actuator_biasprm[j, 0] = 1, x  # affine
        elif cause == "saturation": m.actuator_ctrllimited[j], m.actuator_ctrlrange[j] = 1, (-x["limit"], x["limit"])
        elif cause == "joint_spring": m.jnt_stiffness[m.dof_jntid[dof]], m.qpos_spring[adr] = x["stiffness"], x["rest"]
        elif cause == "encoder_offset": self.offset[j] = x["offset"]
        elif cause == "encoder_gain": self.gain[j] = x["gain"]
        elif cause == "encoder_eccentricity": self.wobble[:, j] = x["size"], x["phase"]
        elif cause == "link_mass":
            for b in (i for i in range(m.nbody) if m.body(i).name.removesuffix("_motor") == x["link"]):
                m.body_mass[b], m.body_inertia[b] = x["factor"] * m.body_mass[b], x["factor"] * m.body_inertia[b]
        elif cause == "tilted_base": m.opt.gravity[:] = x["gravity"]
        elif cause == "joint_stop":
            i = m.dof_jntid[dof]
            m.jnt_limited[i], m.jnt_range[i] = 1, (-20, x["stop"]) if x["side"] == "upper" else (x["stop"], 20)
            m.jnt_solref[i], m.jnt_solimp[i] = (x["time_constant"], 1), (0.8, 0.9, 0.02, 0.5, 2)
        elif cause == "joint_elasticity": m.jnt_stiffness[flex], m.dof_damping[m.jnt_dofadr[flex]] = x["stiffness"], x["damping"]
        elif cause == "backlash":
            m.jnt_limited[flex], m.jnt_range[flex] = 1, (-x["gap"] / 2, x["gap"] / 2)
            m.jnt_solref[flex], m.jnt_solimp[flex] = (0.004, 1), (0.95, 0.99, 0.001, 0.5, 2)
        else: self._running(cause, x, j, m, dof, adr)

    def _running(self, cause, x, j, m, dof, adr):
        """The causes that depend on the state or on the time: what is added to friction or force before each step."""
        d, names, slow, now = self.data, self.case["moving"], [0.0], lambda: self.session + self.data.time
        here, pair = self.case["on"][cause], [self.qadr[names.index(k)] for k in self.case["on"][cause]]

        def load():  # M a + bias: all that is left of the motor's torque when friction has had its part
            slow[0] += 0.1 * (d.qfrc_actuator[dof] + d.qfrc_passive[dof] + d.qfrc_constraint[dof] - slow[0])
            return abs(slow[0])

        def wind():
            blow = x["force"] * (0.4 + math.sin(2 * math.pi * x["frequency_hz"] * now()))
            d.xfrc_applied[self.tip, :2] = blow * np.array(x["towards"])
            return 0.0

        def stick():
            return x["coulomb"] + (x["static"] - x["coulomb"]) * math.exp(-((d.qvel[dof] / x["speed"]) ** 2))

        rub = {"stribeck_friction": stick, "load_friction": lambda: x * load(), "one_way_friction": lambda: 2 * x * (d.qvel[dof] > -1e-3),
               "warming_friction": lambda: 2 * x * math.exp(-3 * now() / self.total),
               "intermittent_brake": lambda: 2 * x * (math.sin(2 * math.pi * now() / 3.1 + 1) > 0.3)}  # fmt: skip
        push = {"torque_ripple": lambda: x["size"] * math.sin(x["per_turn"] * d.qpos[adr] + x["phase"]), "wind_gusts": wind,
                "coupled_cogging": lambda: x["sizes"][here.index(names[j])] * math.sin(np.dot(x["per_turn"], d.qpos[pair])),
                "quadratic_drag": lambda: -x * d.qvel[dof] * abs(d.qvel[dof]),
                "drifting_torque_constant": lambda: -1.6 * x * now() / self.total * d.ctrl[j],
                "torque_crosstalk": lambda: x["factor"] * d.ctrl[names.index(x["from"])]}  # fmt: skip
        if cause in rub | push:
            self.before.append((m.dof_frictionloss if cause in rub else d.qfrc_applied, dof, (rub | push)[cause]))

    def run(self, motion, nominal, rng):
        """One trial: the log (t, q, tau) and, without noise, time, position and velocity as encoders and clock tell them."""
        import mujoco
        m, d, case, n, (nm, nd) = self.model, self.data, self.case, len(self.qadr), nominal
        mujoco.mj_resetData(m, d)
        d.qpos[self.qadr] = motion["q"][0]
        every, steps = round(1 / case["rate"] / STEP), round((PREROLL + motion["duration"]) / STEP)
        w, noise, jitter, k, last = np.array(case["stiffness"]), case["encoder"], case["jitter_steps"], 0, None
        kept, rows, clean, speed = np.zeros((steps + 64, n)), [], [], np.zeros(n)
        while k < steps:
            t, angle = k * STEP, d.qpos[self.qadr]
            true = self.gain * angle + self.offset + self.wobble[0] * np.sin(angle + self.wobble[1])
            rate = d.qvel[self.dof] * (self.gain + self.wobble[0] * np.cos(angle + self.wobble[1]))
            q = np.round(true / noise["size"]) * noise["size"] if noise["kind"] == "quantised" else rng.normal(true, noise["size"])
            since, last = last or (k - every, q), (k, q)
            gap, i = (k - since[0]) * STEP, min(round(t / GRID), len(motion["t"]) - 1)
            speed += (1 - math.exp(-2 * math.pi * 18 * gap)) * ((q - since[1]) / gap - speed)  # its own estimate, below 18 Hz
            nd.qpos[:], nd.qvel[:] = q, motion["v"][i]
            nd.qacc[:] = motion["a"][i] + w * w * (motion["q"][i] - q) + 1.6 * w * (motion["v"][i] - speed)
            mujoco.mj_inverse(nm, nd)
            span = every + int(rng.integers(-jitter, jitter + 1))
            kept[k : k + span] = tau = nd.qfrc_inverse.copy()
            if t >= PREROLL - 1e-9:
                rows.append([self.clock * (t - PREROLL), *q, *tau])
                clean.append([rows[-1][0], *true, *rate / self.clock])
            for s in range(k, k + span):
                d.ctrl[:] = kept[np.maximum(0, s - self.delay), np.arange(n)]
                m.dof_frictionloss[:], d.qfrc_applied[:] = self.loss, 0
                for where, dof, value in self.before:
                    where[dof] += value()
                mujoco.mj_step(m, d)
            k += span
        self.session += motion["duration"]
        return np.array(rows), np.array(clean)

def simulate(case, trials=None):
    """All trials of a case: the URDF tree to declare, the logs, what was misdeclared, and the figures for the answer."""
    import mujoco
    survey, n = Survey(case), len(case["moving"])
    declared, changed = misdeclare(survey.root, case["seed"]) if case["misdeclared"] else (copy.deepcopy(survey.root), {})
    nominal, true = ((m, mujoco.MjData(m)) for m in (_spec(declared).compile(), survey.model))
    plant, rng = Plant(case, survey), np.random.default_rng([case["seed"], 3])
    logs, sums, reach = [], np.zeros((3, n)), np.zeros(n)
    for motion in survey.motions[:trials]:
        rows, clean = plant.run(motion, nominal, rng)
        q, v, dt = clean[:, 1 : n + 1], clean[:, n + 1 :], np.diff(clean[:, :1], axis=0)
        state = ((q[1:] + q[:-1]) / 2, (v[1:] + v[:-1]) / 2, np.diff(v, axis=0) / dt)
        rigid, tau = inverse(*nominal, *state), rows[:-1, n + 1 :]
        sums += [np.sum(x * x, 0) for x in (tau, tau - rigid, rigid - inverse(*true, *state))]
        reach = np.maximum(reach, np.abs(q - case["home"]).max(0))
        if x := case["parameters"].get("lost_encoder_samples"):  # the log repeats the last ones, of all joints
            for k in 1 + np.flatnonzero(rng.random(len(rows) - 1) < x["chance"]):
                rows[k : k + int(rng.integers(1, x["longest"] + 1)), 1 : n + 1] = rows[k - 1, 1 : n + 1]
        logs.append(rows)
    check = np.sqrt(sums[1:] / sums[0]).round(4).tolist()
    figures = {"torque_not_explained": dict(zip(case["moving"], check[0])), "of_which_nuisance": dict(zip(case["moving"], check[1])),
               "reach": reach.round(2).tolist(), "trials": [r["kind"] for r in survey.motions]}  # fmt: skip
    return declared, logs, changed, figures

def record(folder: pathlib.Path, seed: int, name: str | None = None, case: dict | None = None) -> dict:
    """Draw the case of this seed, simulate it, write the recordings into the folder and return the answer."""
    case, folder, name = case or draw(seed), pathlib.Path(folder), name or f"case-{seed}"
    for softer, level in ((1.0, None), (0.7, None), (1.4, None), (1.0, "medium"), (1.0, "small")):  # should the arm run away
        case = draw(seed, case["causes"], level) if level else case
        declared, logs, changed, figures = simulate(case | {"stiffness": [softer * w for w in case["stiffness"]]})
        if max(figures["reach"]) < 3: break
    folder.mkdir(parents=True, exist_ok=True)
    ET.indent(declared)
    ET.ElementTree(declared).write(folder / "robot.urdf", encoding="utf-8", xml_declaration=True)
    q, tau = ([f"{x}{i}" for i, _ in enumerate(case["moving"], 1)] for x in ("q", "tau"))
    (folder / "robot.toml").write_text(f'name = "{name}"\nurdf = "robot.urdf"\njoints = {json.dumps(case["moving"])}\n\n'
        f'[channels]\ntime = "t"\nposition = {json.dumps(q)}\ntorque = {json.dumps(tau)}\n')
    for k, rows in enumerate(logs, 1):
        np.savetxt(folder / f"trial_{k:02d}.csv", rows, "%.9g", ",", header=",".join(["t", *q, *tau]), comments="")
    joints = sorted({j for on in case["on"].values() for j in on}, key=case["moving"].index)
    nuisance = {"nominal_numbers": changed, "viscous_friction": dict(zip(case["moving"], case["viscous"])),
                "encoder": case["encoder"], "rate_hz": case["rate"], "jitter_s": case["jitter_steps"] * STEP}  # fmt: skip
    return {"name": name, "seed": int(seed), "kind": case["kind"], "causes": case["causes"], "parameters": case["parameters"],
            "joints": joints, "nuisance": nuisance, "robot": case["robot"], "moving": case["moving"], "figures": figures}  # fmt: skip

def main(argv: list[str]) -> None:
    """FOLDER SEED COUNT: write COUNT cases case_001.. with the seeds SEED, SEED+1, .. and answers.json."""
    folder, seed, answers = pathlib.Path(argv[0]), int(argv[1]), {}
    for k, here in enumerate(f"case_{i + 1:03d}" for i in range(int(argv[2]))):
        answers[here] = record(folder / here, seed + k, here.replace("_", "-"))
        (folder / "answers.json").write_text(json.dumps(answers, indent=1) + "\n")
        print(here, answers[here]["kind"], answers[here]["causes"], flush=True)

if __name__ == "__main__":
    main(sys.argv[1:])
