"""An arm of two sections in space, each bent to a circle, somewhere in a laboratory with axes of its own."""

import numpy as np
from scipy.spatial.transform import Rotation

#: Columns: x, y and z of a link where the arm is straight, in the world (z up).
STRAIGHT = {
    "hanging": np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "upright": np.eye(3),
    "horizontal": np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
}
LENGTHS = (0.14, 0.10)
RATE = 100.0
#: Name, arc length [m], radius [m], angle [rad].
MARKERS = (("base", 0.0, 0.0, 0.0), ("middle", 0.14, 0.0, 0.0), ("tip", 0.24, 0.0, 0.0), ("side", 0.24, 0.03, 0.7))


def bent(length, bend):
    """Place and axes of the end of a section in those of its beginning; bend: complex [rad], towards x and y."""
    angle = abs(bend)
    turn = Rotation.from_rotvec([-bend.imag, bend.real, 0.0]).as_matrix()
    if angle < 1e-12:
        return np.array([0.0, 0.0, length]), turn
    aside = length * (1 - np.cos(angle)) / angle * bend / angle
    return np.array([aside.real, aside.imag, length * np.sin(angle) / angle]), turn


def pose(bends, arc):
    """(3,) place and (3, 3) axes of the backbone at an arc length [m], from the base, z along the arm."""
    place, axes = np.zeros(3), np.eye(3)
    for length, bend in zip(LENGTHS, bends, strict=True):
        part = min(arc, length)
        if part <= 0:
            break
        step, turn = bent(part, bend * part / length)
        place, axes, arc = place + axes @ step, axes @ turn, arc - part
    return place, axes


class SpaceLaboratory:
    """Straight for half a second, then bent by pressures; markers (name, arc length, radius, angle); bodies at some of them.

    ``positions`` (T, M, 3) [m] and ``turns`` (T, M, 4), real part first, are in the laboratory's axes; ``world`` and ``axes``
    in the arm's frame. The first chamber of the first section lies towards x of the base, that of the second at an angle from it.
    """

    def __init__(
        self, mount="hanging", up="+z", yaw=0.0, seconds=3.0, *, markers=MARKERS, body=(0.3, -0.2, 0.5), gains=(0.3, 0.25),
        second=0.0, one=False,
    ):  # fmt: skip
        self.markers = markers
        self.time = np.arange(int(seconds * RATE)) / RATE
        on = np.clip(self.time - 0.5, 0, 0.5)[:, None]
        phase = np.array([0.0, 0.8, 1.9, 0.4, 1.3, 2.6])
        self.pressures = 1.0 + 2 * on * np.sin(phase + 2 * self.time[:, None] * (1 + 0.3 * np.arange(6)))
        self.pressures[self.time < 0.5] = 1.0
        if one:  # section: an even arm under the first three alone
            self.pressures[:, 3:] = self.pressures[:, :3]
        ways = np.exp(2j * np.pi * np.arange(3) / 3)
        torques = [
            gain * self.pressures[:, 3 * k : 3 * k + 3] @ ways * np.exp(1j * angle)
            for k, (gain, angle) in enumerate(zip(gains, (0.0, second), strict=True))
        ]
        self.torque = np.stack([part for torque in torques for part in (torque.real, torque.imag)], axis=1)
        frames = [[pose(bends, arc) for _, arc, _, _ in self.markers] for bends in zip(*torques, strict=True)]
        places = np.array([[place for place, _ in frame] for frame in frames])
        axes = np.array([[turn for _, turn in frame] for frame in frames])
        beside = np.array([[r * np.cos(angle), r * np.sin(angle), 0.0] for _, _, r, angle in self.markers])
        places = places + np.einsum("tmij,mj->tmi", axes, beside)
        base = STRAIGHT[mount]
        self.world, self.axes = places @ base.T, base @ axes
        turn = {"+z": "xyz", "+y": "zxy"}[up]  # where the world's axes point in the laboratory
        self.laboratory = np.array([np.eye(3)["xyz".index(axis)] for axis in turn]).T @ Rotation.from_euler("z", yaw).as_matrix()
        self.place = np.array([0.4, -1.3, 2.1])
        self.positions = self.world @ self.laboratory.T + self.place
        bodies = self.laboratory @ self.axes @ Rotation.from_rotvec(body).as_matrix()
        quaternions = Rotation.from_matrix(bodies.reshape(-1, 3, 3)).as_quat().reshape(*bodies.shape[:2], 4)
        self.turns = np.roll(quaternions, 1, axis=-1)
        self.names = [name for name, *_ in self.markers]

    def beside(self, name, radius):
        """(T, 2, 3) [m] where points beside a marker are, towards x and y of its link."""
        m = self.names.index(name)
        return self.world[:, m, None] + radius * self.axes[:, m, :, :2].swapaxes(1, 2)

    def x(self):
        """X of the arm in the laboratory, as hsr-import takes it."""
        return ",".join(repr(float(value)) for value in self.laboratory[:, 0])
