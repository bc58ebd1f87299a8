"""The map from pressures to bending stiffness, bending angle and torque (Eqs. (1), (4) and (5) of the paper), with uncertainty.

    Keq = a0 + a1 P1 + a2 P2    (1)        phi = b0 + b1 P1 + b2 P2    (4)        tau = Keq phi    (5)

Both planes were fitted to the 16 rows of Table II of Arachchige and Godage, Hybrid Soft Robots Incorporating Soft and Stiff
Elements, RoboSoft 2022, doi 10.1109/ROBOSOFT54090.2022.9762183, which the package contains in ``data``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hsr_pin.errors import PressureError, quoted
from hsr_pin.resources import resource
from hsr_pin.robot.scatter import PressureUncertainty, Scatter
from hsr_pin.trajectory import Array

#: Largest accepted pressure [bar]: the next whole bar above what the paper itself commands (3.26 bar in its Table II), and the
#: first at which Eqs. (1) and (4) reach the straight arm at every stiffness of its Table I, up to 4 Nm/rad.
MAX_PRESSURE = 4.0


def measured_rows() -> Array:
    """Read the (16, 4) rows behind Eqs. (1) and (4): phi [rad], P1, P2 [bar], Keq [Nm/rad]."""
    return np.asarray(np.loadtxt(resource("data", "hsr2022_table2.csv"), delimiter=",", skiprows=1))


@dataclass(frozen=True, eq=False)
class PressureMap:
    """The planes of stiffness and bending over the pressures; vectorised: pressures P are (..., 2) [bar], other quantities (...).

    Attributes:
        stiffness_plane: (a0, a1, a2) of Eq. (1) [Nm/rad, Nm/rad/bar, Nm/rad/bar].
        bending_plane: (b0, b1, b2) of Eq. (4) [rad, rad/bar, rad/bar].
        rows: (n, 4) phi, P1, P2, Keq: the measurements behind the planes; None for the 16 rows of the package.
        max_pressure: upper end of the regulators' range, which starts at 0 [bar].
    """

    stiffness_plane: tuple[float, float, float]
    bending_plane: tuple[float, float, float]
    rows: Array | None = None
    max_pressure: float = MAX_PRESSURE

    def __post_init__(self) -> None:
        planes = _finite("planes", [self.stiffness_plane, self.bending_plane])
        if abs(np.linalg.det(planes[:, 1:])) < 1e-9:
            raise PressureError("planes", expected="stiffness and bending with linearly independent pressure coefficients")
        if not _finite("max_pressure", self.max_pressure) > 0:
            raise PressureError("max_pressure", expected="more than zero [bar]", received=f"{self.max_pressure:g}")

    @classmethod
    def fit(cls, rows: ArrayLike | None = None) -> PressureMap:
        """Fit both planes by least squares.

        Args:
            rows: (n, 4) phi [rad], P1, P2 [bar], Keq [Nm/rad]; None: the 16 rows behind the paper's equations.

        Raises:
            PressureError: there are fewer than four rows, a value is not a number, or all pressures are on one line.
        """
        table = measured_rows() if rows is None else _rows(rows)
        (a0, b0), (a1, b1), (a2, b2) = Scatter.fit(table).planes.tolist()
        return cls((a0, a1, a2), (b0, b1, b2), table)

    @cached_property
    def scatter(self) -> Scatter:
        """Scatter of the measurements about their own least-squares planes."""
        return Scatter.fit(measured_rows() if self.rows is None else self.rows)

    def stiffness(self, P: ArrayLike) -> Array:
        """Return the stiffness Keq [Nm/rad] by Eq. (1).

        Raises:
            PressureError: P is out of range, or so low that the stiffness would not be positive.
        """
        pressures = self._checked(P)
        keq = _plane(self.stiffness_plane, pressures)
        if np.any(keq <= 0):
            at = pressures[keq <= 0][0]
            low, high = self.stiffness_range()
            raise PressureError(
                f"stiffness at P1, P2 = {at[0]:.6g}, {at[1]:.6g} bar",
                expected=f"more than {low:.3g} and up to {high:.3g} Nm/rad",
                received=f"{np.min(keq):.4g} by Eq. (1)",
                hint="raise P1 or P2",
            )
        return keq

    def bending(self, P: ArrayLike) -> Array:
        """Return the bending angle phi [rad] of the free arm by Eq. (4).

        Raises:
            PressureError: P is out of range.
        """
        return _plane(self.bending_plane, self._checked(P))

    def torque(self, P: ArrayLike, keq: ArrayLike | None = None) -> Array:
        """Return the torque tau [N m] on every joint by Eq. (5); ``keq`` [Nm/rad] replaces Eq. (1) if the stiffness is known.

        Raises:
            PressureError: P is out of range, or the stiffness is not positive.
        """
        stiffness = self.stiffness(P) if keq is None else _positive("keq", keq)
        return np.asarray(stiffness * self.bending(P))

    def pressures_for(self, keq: ArrayLike, phi: ArrayLike) -> Array:
        """Return the pressures (..., 2) [bar] that give both ``keq`` [Nm/rad] and ``phi`` [rad].

        Raises:
            PressureError: a value is not a number, or not reachable within the pressure range (the message contains the range).
        """
        stiffness, angle = np.broadcast_arrays(_positive("keq", keq), _finite("phi", phi))
        pressures = self._solve(stiffness, angle)
        outside = np.any(~self._within(pressures), axis=-1)
        if np.any(outside):
            self._refuse(float(stiffness[outside][0]), float(angle[outside][0]))
        return np.asarray(np.clip(pressures, 0.0, self.max_pressure))

    def pressures_for_torque(self, keq: ArrayLike, tau: ArrayLike) -> Array:
        """Return the pressures (..., 2) [bar] that give ``tau`` [N m] along the line of constant stiffness ``keq`` [Nm/rad].

        Raises:
            PressureError: as :meth:`pressures_for`.
        """
        return self.pressures_for(keq, _finite("tau", tau) / _positive("keq", keq))

    def stiffness_range(self) -> tuple[float, float]:
        """Return the range of stiffness [Nm/rad] within the pressure range; a lower end of 0 is itself not a valid stiffness."""
        top = self.max_pressure
        corners = _plane(self.stiffness_plane, np.array([[0.0, 0.0], [top, 0.0], [0.0, top], [top, top]]))
        return max(0.0, float(corners.min())), float(corners.max())

    def bending_range(self, keq: float) -> tuple[float, float]:
        """Return the range of the bending angle [rad] at a stiffness; it includes negative values if Eq. (4) does.

        Raises:
            PressureError: no pressures within the range give this stiffness.
        """
        stiffness = float(_positive("keq", keq))
        start = self._solve(stiffness, 0.0)
        slope = self._solve(stiffness, 1.0) - start  # pressures are linear in phi along the line
        ends = np.sort([(0.0 - start) / slope, (self.max_pressure - start) / slope], axis=0)
        low, high = float(ends[0].max()), float(ends[1].min())
        if low > high:
            reach = self.stiffness_range()
            raise PressureError(
                "keq", expected=f"more than {reach[0]:.3g} and up to {reach[1]:.3g} Nm/rad", received=f"{keq:.6g}"
            )
        return low, high

    def torque_range(self, keq: float) -> tuple[float, float]:
        """Return the range of the torque [N m] at a stiffness; see :meth:`bending_range`."""
        low, high = self.bending_range(keq)
        return keq * low, keq * high

    def uncertainty(self, P: ArrayLike, keq: ArrayLike | None = None) -> PressureUncertainty:
        """Return the uncertainty of Keq, phi and tau at P from the scatter of the measurements; ``keq`` as in :meth:`torque`.

        Raises:
            PressureError: as :meth:`torque`.
        """
        pressures = self._checked(P)
        stiffness = self.stiffness(P) if keq is None else _positive("keq", keq)
        return self.scatter.at(pressures, stiffness, self.bending(P), stiffness_known=keq is not None)

    def _solve(self, keq: ArrayLike, phi: ArrayLike) -> Array:
        planes = np.array([self.stiffness_plane, self.bending_plane])
        wanted = np.stack([np.asarray(keq, dtype=float), np.asarray(phi, dtype=float)], axis=-1) - planes[:, 0]
        return np.asarray(wanted @ np.linalg.inv(planes[:, 1:]).T)

    def _within(self, pressures: Array) -> NDArray[np.bool_]:
        """Return whether each pressure is in range, with a tolerance for rounding errors of an inverse."""
        return np.asarray((pressures >= -1e-9) & (pressures <= self.max_pressure + 1e-9))

    def _checked(self, P: ArrayLike) -> Array:
        pressures = _finite("pressures", P)
        if pressures.ndim == 0 or pressures.shape[-1] != 2:
            raise PressureError(
                "pressures", expected="P1 and P2 [bar], an array of shape (..., 2)", received=str(pressures.shape)
            )
        good = self._within(pressures)
        if not np.all(good):
            bad = np.argwhere(~good)[0]
            raise PressureError(
                f"P{bad[-1] + 1}",
                expected=f"a pressure from 0 to {self.max_pressure:g} bar",
                received=f"{pressures[tuple(bad)]:.6g}",
            )
        return pressures

    def _refuse(self, keq: float, phi: float) -> NoReturn:
        low, high = self.bending_range(keq)
        raise PressureError(
            f"bending at Keq {keq:.6g} Nm/rad",
            expected=f"{low:.4g} to {high:.4g} rad (torque {keq * low:.4g} to {keq * high:.4g} N m)",
            received=f"{phi:.6g} rad ({keq * phi:.6g} N m)",
            hint=f"the pressures are limited to 0 to {self.max_pressure:g} bar",
        )


def _plane(coefficients: tuple[float, float, float], pressures: Array) -> Array:
    return np.asarray(coefficients[0] + pressures @ np.array(coefficients[1:]))


def _finite(name: str, values: ArrayLike) -> Array:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise PressureError(name, expected="numbers", received=quoted(values)) from error
    if not np.all(np.isfinite(array)):
        raise PressureError(name, expected="finite numbers", received=f"{array[~np.isfinite(array)].flat[0]}")
    return array


def _positive(name: str, values: ArrayLike) -> Array:
    array = _finite(name, values)
    if np.any(array <= 0):
        raise PressureError(name, expected="a stiffness above zero [Nm/rad]", received=f"{array.min():.6g}")
    return array


def _rows(values: ArrayLike) -> Array:
    table = _finite("rows", values)
    if table.ndim != 2 or table.shape[1] != 4 or len(table) < 4:
        raise PressureError("rows", expected="four or more rows of phi, P1, P2, Keq", received=f"shape {table.shape}")
    if np.linalg.matrix_rank(np.c_[np.ones(len(table)), table[:, 1:3]]) < 3:
        raise PressureError("rows", expected="pressures that span a plane", received="pressures on one line")
    return table


#: Eqs. (1) and (4) as printed in the paper.
PAPER = PressureMap(stiffness_plane=(-2.594, 0.8183, 1.415), bending_plane=(-0.7742, -0.2892, 0.7321))
