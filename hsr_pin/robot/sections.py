"""Stretches of an arm that differ in length, mass, stiffness and damping, each with an input of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.trajectory import Array, Section


def whole(sections: Sequence[Section]) -> dict[str, float]:
    """Length, mass, keq and damping of the arm that sections make: springs in series, damping of a curvature's rate averaged."""
    length = sum(section.length for section in sections)
    return {
        "length": length,
        "mass": sum(section.mass for section in sections),
        "keq": 1 / sum(1 / section.keq for section in sections),
        "damping": sum(section.damping * (section.length / length) ** 2 for section in sections),
    }


def edges(sections: Sequence[Section]) -> Array:
    """(S + 1,) arc lengths between the sections, over the arm's."""
    ends = np.cumsum([0.0, *(section.length for section in sections)])
    return np.asarray(ends / ends[-1])


def covered(sections: Sequence[Section], starts: Array, ends: Array) -> Array:
    """(n, S) how much of each stretch from ``starts`` to ``ends`` (n,) lies in each section; arc lengths over the arm's."""
    border = edges(sections)
    overlap = np.minimum(ends[:, None], border[1:]) - np.maximum(starts[:, None], border[:-1])
    return np.asarray(np.maximum(overlap, 0.0))


def inputs(sections: Sequence[Section], links: int) -> Array:
    """(N, S) share of each element that lies in each section, whose torque it takes by that; without any, one for all."""
    if not sections:
        return np.ones((links, 1))
    border = np.arange(links + 1) / links
    return covered(sections, border[:-1], border[1:]) * links


def along_sections(sections: Sequence[Section], links: int) -> tuple[Array, Array]:
    """(N,) stiffness and damping of the elements over those of the uniform arm with the same :func:`whole`."""
    if not sections:
        return np.ones(links), np.ones(links)
    share, arm = inputs(sections, links), whole(sections)
    stiffness, damping = (np.array([getattr(s, name) * s.length for s in sections]) for name in ("keq", "damping"))
    compliance = (share / stiffness).sum(axis=1) * arm["keq"] * arm["length"]
    scale = arm["damping"] * arm["length"]
    return 1 / compliance, share @ damping / scale if scale else np.zeros(links)


def bodies_of(sections: Sequence[Section], starts: Array, ends: Array) -> tuple[Array, Array, Array]:
    """(n,) each of rigid stretches: mass over the arm's; from start to centre, and radius of gyration, over the arm's length."""
    border, mass = edges(sections), np.array([section.mass for section in sections])
    density = mass / mass.sum() / np.diff(border)
    low = np.clip(border[:-1], starts[:, None], ends[:, None]) - starts[:, None]
    high = np.clip(border[1:], starts[:, None], ends[:, None]) - starts[:, None]
    zeroth, first, second = (((high**k - low**k) / k * density).sum(axis=1) for k in (1, 2, 3))
    centre = first / zeroth
    return zeroth, centre, np.sqrt(np.maximum(second / zeroth - centre**2, 0.0))
