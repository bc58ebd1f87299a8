"""The arrays of planar bodies are those of the model that Pinocchio reads from the URDF, for any arm."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr_pin.robot.chain import Arms, chain_of
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification


def number(lower, upper):
    return st.floats(lower, upper, allow_subnormal=False)


specifications = st.builds(
    ArmSpecification,
    links=st.integers(1, 40),
    keq=number(1e-3, 1e3),
    damping=number(0, 10),
    placement=st.sampled_from(["base", "mid"]),
    mount=st.sampled_from(["hanging", "upright", "horizontal", "flat"]),
    length=number(1e-2, 10),
    mass=number(1e-3, 100),
    diameter=number(1e-3, 1),
    tip_mass=st.just(0.0) | number(1e-6, 10),
    tilt=number(-np.pi, np.pi),
)


def check(arm):
    model, chain = build_model(arm).model, chain_of(Arms.of([arm]))
    bodies, placements = list(model.inertias)[1:], list(model.jointPlacements)
    tip = model.frames[model.getFrameId("tip")].placement.translation
    joints = [placement.translation for placement in placements[2:]] + [tip]
    turned = placements[1].rotation.T @ model.gravity.linear  # in the axes of the base: z along the arm, x across it
    scale = arm.length
    np.testing.assert_allclose(chain.mass[0], [body.mass for body in bodies], rtol=1e-13)
    np.testing.assert_allclose(chain.lever[0], [body.lever[2] for body in bodies], rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(chain.inertia[0], [body.inertia[1, 1] for body in bodies], rtol=1e-9)
    np.testing.assert_allclose(chain.reach[0], [joint[2] for joint in joints], rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(chain.gravity[0], [turned[2], turned[0]], rtol=0, atol=1e-13)


@settings(max_examples=60, deadline=None)
@given(specifications)
def test_the_bodies_are_those_of_the_urdf(arm):
    check(arm)


@pytest.mark.parametrize("links", [200, 1000])
def test_very_many_bodies_are_those_of_the_urdf(links):
    check(ArmSpecification(links=links, placement="mid", tip_mass=0.05, tilt=0.3))


@settings(max_examples=30, deadline=None)
@given(st.lists(specifications, min_size=1, max_size=5))
def test_arms_side_by_side_keep_to_their_rows(some):
    first = some[0]
    arms = [replace(arm, links=first.links, placement=first.placement, mount=first.mount) for arm in some]
    together = Arms.of(arms)
    assert [together.specification(b) for b in range(len(arms))] == arms
    assert len(together) == len(arms)
    chain = chain_of(together)
    for b, arm in enumerate(arms):
        alone = chain_of(Arms.of([arm]))
        for name in ("mass", "lever", "inertia", "reach", "gravity"):
            np.testing.assert_array_equal(getattr(chain, name)[b], getattr(alone, name)[0])
    assert chain_of(together.subset(slice(0, 1))).mass.shape == (1, first.links)
