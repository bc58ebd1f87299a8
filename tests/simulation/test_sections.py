"""An arm of sections: what each is by itself, bodies that weigh as they do, and inputs that act where they are."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from hsr_pin.errors import InputError, SpecificationError
from hsr_pin.robot.chain import Arms, chain_of
from hsr_pin.robot.sections import along_sections, bodies_of, inputs
from hsr_pin.robot.specification import ArmSpecification, joint_arc_lengths
from hsr_pin.robot.urdf import arm_to_urdf
from hsr_pin.simulation.load import Load
from hsr_pin.simulation.scenario import Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Section

UNEQUAL = (Section(0.10, 0.08, 3.0, 0.2), Section(0.07, 0.03, 1.5, 0.05), Section(0.05, 0.01, 1.0, 0.0))


def arm_of(sections, **more):
    return ArmSpecification.in_sections(sections, **{"links": 6, "placement": "mid", **more})


def test_equal_sections_under_one_torque_are_the_uniform_arm():
    uniform = ArmSpecification(links=6, placement="mid", bending="space", cross_tilt=0.2, torsion=0.7)
    half = Section(uniform.length / 2, uniform.mass / 2, 2 * uniform.keq, 2 * uniform.damping)
    sections = arm_of([half, half], cross_tilt=0.2, torsion=0.7)
    for name in ("length", "mass", "keq", "damping"):
        assert getattr(sections, name) == pytest.approx(getattr(uniform, name), rel=1e-14)
    one, other = (simulate(step_scenario(arm, [0.5, 0.3], duration=0.5), dynamics="compiled") for arm in (uniform, sections))
    np.testing.assert_allclose(other.trajectory.positions, one.trajectory.positions, atol=1e-12)


@pytest.mark.parametrize("links", [2, 5, 11])
def test_springs_in_series_are_the_sections_own(links):
    """Where sections end within elements too: compliance is never lost."""
    arm = arm_of(UNEQUAL, links=links)
    stiffness, damping = along_sections(UNEQUAL, links)
    assert (1 / (links * arm.keq * stiffness)).sum() == pytest.approx(sum(1 / section.keq for section in UNEQUAL))
    bent = inputs(UNEQUAL, links).T @ (1 / (links * arm.keq * stiffness))
    if links == 11:  # elements of 2 cm; the first section is five of them
        assert bent[0] == pytest.approx(1 / UNEQUAL[0].keq)
    assert damping.mean() == pytest.approx(1.0)


@pytest.mark.parametrize("placement", ["base", "mid", "shifted"])
def test_links_weigh_what_they_are_cut_from(placement):
    joints = joint_arc_lengths(6, placement)
    ends = np.append(joints[1:], 1.0)
    border = np.cumsum([0.0, *(s.length for s in UNEQUAL)]) / 0.22

    def density(s):
        k = min(int(np.searchsorted(border, s, side="right")) - 1, 2)
        return UNEQUAL[k].mass / 0.12 / (UNEQUAL[k].length / 0.22)

    for start, end, *got in zip(joints, ends, *bodies_of(UNEQUAL, joints, ends), strict=True):
        inside = [s for s in border if start < s < end] or None
        zeroth, first, second = (
            quad(lambda s, k=k, a=start: (s - a) ** k * density(s), start, end, points=inside)[0] for k in range(3)
        )
        wanted = [zeroth, first / zeroth, np.sqrt(second / zeroth - (first / zeroth) ** 2)]
        np.testing.assert_allclose(got, wanted, rtol=1e-9)


def test_one_section_has_the_bodies_of_the_uniform_arm():
    plain = ArmSpecification(links=5, placement="shifted", tip_mass=0.02, bending="space")
    alone = arm_of([Section(plain.length, plain.mass, plain.keq, plain.damping)], links=5, placement="shifted", tip_mass=0.02)
    one, other = (chain_of(Arms.of([arm])) for arm in (plain, alone))
    for name in ("mass", "lever", "inertia", "reach", "axial"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-13)


def test_every_torque_bends_its_own_section():
    """Nearly without weight, each section is an arc of its torque over its stiffness."""
    sections = [Section(0.12, 1e-6, 2.0, 0.1), Section(0.12, 1e-6, 1.0, 0.1)]
    arm = arm_of(sections, links=8)
    torque = (0.6 + 0.2j, -0.3 + 0.4j)
    command = np.tile([0.6, 0.2, -0.3, 0.4], (2, 1))
    run = simulate(Scenario(arm, [0, 0.01], command, Settled(torque)))
    bends = run.trajectory.joint_angles[0, :, 0] + 1j * run.trajectory.joint_angles[0, :, 1]
    np.testing.assert_allclose([bends[:4].sum(), bends[4:].sum()], [torque[0] / 2.0, torque[1] / 1.0], rtol=1e-4)


def test_compiled_is_pinocchio_with_sections_and_loads():
    arm = arm_of(UNEQUAL, torsion=0.8, mount="horizontal")
    torque = np.where(np.arange(41)[:, None] < 5, 0.0, [0.3, 0.1, -0.2, 0.3, 0.1, -0.4])
    scenario = Scenario(arm, np.arange(41) * 0.01, torque, loads=(Load(0.15, [0.1, 0.2, 0.0]), Load(0.22, [0.0, 0.0, 0.1])))
    compiled, pinocchio = (simulate(scenario, dynamics=way) for way in ("compiled", "rnea"))
    assert np.abs(compiled.trajectory.positions - pinocchio.trajectory.positions).max() < 1e-10
    assert compiled.energy().rise < 1e-3


def test_what_does_not_fit_is_said():
    with pytest.raises(SpecificationError, match="keq of a section: expected a number, more than zero, got 0"):
        Section(0.1, 0.1, 0.0, 0.1)
    with pytest.raises(SpecificationError, match="sections: expected none where the arm bends in a plane"):
        replace(arm_of(UNEQUAL), bending="plane")
    with pytest.raises(SpecificationError, match="sections: expected none for a URDF"):
        arm_to_urdf(arm_of(UNEQUAL))
    with pytest.raises(InputError, match="for each of 3 sections"):
        Scenario(arm_of(UNEQUAL), [0, 0.1], np.zeros((2, 2)))
    with pytest.raises(InputError, match="one torque, or 3"):
        Scenario(arm_of(UNEQUAL), [0, 0.1], np.zeros((2, 6)), Settled((0.1, 0.2)))
