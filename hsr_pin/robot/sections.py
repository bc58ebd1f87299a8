"""Sections of an arm that differ in length, mass, stiffness and damping, each with a separate input."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.trajectory import Array, Section


def whole(sections: Sequence[Section]) -> dict[str, float]:
    """Return length, mass, keq and damping of the arm that consists of these sections.

    The springs are in series; the damping is the average for uniform curvature.
    """
    length = sum(section.length for section in sections)
    return {
        "length": length,
        "mass": sum(section.mass for section in sections),
        "keq": 1 / sum(1 / section.keq for section in sections),
        "damping": sum(section.damping * (section.length / length) ** 2 for section in sections),
    }


def edges(sections: Sequence[Section]) -> Array:
    """Return the boundaries (S + 1,) of the sections as relative arc lengths."""
    ends = np.cumsum([0.0, *(section.length for section in sections)])
    return np.asarray(ends / ends[-1])


def covered(sections: Sequence[Section], starts: Array, ends: Array) -> Array:
    """Return the overlap (n, S) of intervals from ``starts`` to ``ends`` (n,) with each section, in relative arc lengths."""
    border = edges(sections)
    overlap = np.minimum(ends[:, None], border[1:]) - np.maximum(starts[:, None], border[:-1])
    return np.asarray(np.maximum(overlap, 0.0))


def inputs(sections: Sequence[Section], links: int) -> Array:
    """Return the share (N, S) of each section in each element, which is its share of the torque; ones (N, 1) without sections."""
    if not sections:
        return np.ones((links, 1))
    border = np.arange(links + 1) / links
    return covered(sections, border[:-1], border[1:]) * links


def along_sections(sections: Sequence[Section], links: int) -> tuple[Array, Array]:
    """Return stiffness and damping (N,) of the elements relative to the uniform arm with the same :func:`whole`."""
    if not sections:
        return np.ones(links), np.ones(links)
    share, arm = inputs(sections, links), whole(sections)
    stiffness, damping = (np.array([getattr(s, name) * s.length for s in sections]) for name in ("keq", "damping"))
    compliance = (share / stiffness).sum(axis=1) * arm["keq"] * arm["length"]
    scale = arm["damping"] * arm["length"]
    return 1 / compliance, share @ damping / scale if scale else np.zeros(links)


def bodies_of(sections: Sequence[Section], starts: Array, ends: Array) -> tuple[Array, Array, Array]:
    """Return relative mass, centre and radius of gyration (n,) of rigid parts of the arm.

    The masses are relative to that of the arm, the distances from a part's start to its centre and the radii to its length.
    """
    border, mass = edges(sections), np.array([section.mass for section in sections])
    density = mass / mass.sum() / np.diff(border)
    low = np.clip(border[:-1], starts[:, None], ends[:, None]) - starts[:, None]
    high = np.clip(border[1:], starts[:, None], ends[:, None]) - starts[:, None]
    zeroth, first, second = (((high**k - low**k) / k * density).sum(axis=1) for k in (1, 2, 3))
    centre = first / zeroth
    return zeroth, centre, np.sqrt(np.maximum(second / zeroth - centre**2, 0.0))
