"""Input of every picture: a simulated motion, its arm, and the measured motion if there is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array, Marker, Trajectory


@dataclass(frozen=True, eq=False)
class Drawn:
    """Simulated run with its measurement, as input of pictures.

    Attributes:
        label: text that distinguishes it from others in the same picture.
        arm: the simulated arm.
        simulated: simulated motion, with joint angles.
        measured: measured motion of the same markers; None without a measurement.
        forces: (2, T, O, 3) forces of the obstacles of the arm [N], and the points where they act [m]; None if unknown.
    """

    label: str
    arm: ArmSpecification
    simulated: Trajectory
    measured: Trajectory | None = None
    forces: Array | None = None

    def __post_init__(self) -> None:
        angles = self.simulated.joint_angles
        if angles is None or angles.shape[1] != self.arm.links:
            raise ValueError(f"expected a simulated motion with {self.arm.links} joint angles")

    @property
    def angles(self) -> Array:
        """Joint angles (T, N) [rad] of the simulated motion; in space (T, N, 3)."""
        assert self.simulated.joint_angles is not None
        return self.simulated.joint_angles

    @property
    def tip(self) -> Marker:
        """Simulated marker with the largest arc length."""
        return max(self.simulated.markers, key=lambda marker: marker.arc_length)

    @property
    def tip_path(self) -> Array:
        """Smooth path (T', 3) [m] of the simulated tip, with five points for each sample."""
        time, path = self.simulated.time, self.simulated.marker(self.tip.name)
        if len(time) < 4:
            return path
        from scipy.interpolate import Akima1DInterpolator  # imported here, as only pictures need it

        return np.asarray(Akima1DInterpolator(time, path)(np.linspace(time[0], time[-1], 5 * len(time) - 4)))

    @property
    def common(self) -> tuple[Marker, ...]:
        """Markers that were both simulated and measured."""
        if self.measured is None:
            return ()
        names = {marker.name for marker in self.measured.markers}
        return tuple(marker for marker in self.simulated.markers if marker.name in names)

    @property
    def moving(self) -> tuple[Marker, ...]:
        """Markers that were both simulated and measured and are not at the base."""
        return tuple(marker for marker in self.common if marker.arc_length > 0)

    def simulated_at(self, time: Array, marker: str) -> Array:
        """Return the simulated positions (len(time), 3) [m] of a marker; NaN outside the simulated time."""
        own, path = self.simulated.time, self.simulated.marker(marker)
        return np.stack([np.interp(time, own, axis, left=np.nan, right=np.nan) for axis in path.T], axis=-1)

    def gap(self, marker: str) -> Array:
        """Return the distance (T,) [m] from simulation to measurement of a marker at the measured times; NaN if unknown."""
        if self.measured is None:
            raise ValueError("there is no measurement")
        there = self.measured.marker(marker)
        return np.asarray(np.linalg.norm(self.simulated_at(self.measured.time, marker) - there, axis=1))
