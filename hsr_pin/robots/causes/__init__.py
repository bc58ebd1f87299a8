"""Catalogue of causes at the joints of a robot; a new cause is a new file here and a new line in :data:`CAUSES`."""

from hsr_pin.robots.cause import JointCause
from hsr_pin.robots.causes.backlash import Backlash
from hsr_pin.robots.causes.centre_of_mass import CentreOfMass
from hsr_pin.robots.causes.coulomb_friction import CoulombFriction
from hsr_pin.robots.causes.dead_time import DeadTime
from hsr_pin.robots.causes.drive_lag import DriveLag
from hsr_pin.robots.causes.encoder_eccentricity import EncoderEccentricity
from hsr_pin.robots.causes.encoder_gain import EncoderGain
from hsr_pin.robots.causes.encoder_offset import EncoderOffset
from hsr_pin.robots.causes.joint_elasticity import JointElasticity
from hsr_pin.robots.causes.joint_spring import JointSpring
from hsr_pin.robots.causes.joint_stop import JointStop
from hsr_pin.robots.causes.link_inertia import LinkInertia
from hsr_pin.robots.causes.link_mass import LinkMass
from hsr_pin.robots.causes.load_friction import LoadFriction
from hsr_pin.robots.causes.payload import Payload
from hsr_pin.robots.causes.quadratic_damping import QuadraticDamping
from hsr_pin.robots.causes.rotor_inertia import RotorInertia
from hsr_pin.robots.causes.saturation import Saturation
from hsr_pin.robots.causes.stribeck_friction import StribeckFriction
from hsr_pin.robots.causes.tilted_base import TiltedBase
from hsr_pin.robots.causes.torque_bias import TorqueBias
from hsr_pin.robots.causes.torque_gain import TorqueGain
from hsr_pin.robots.causes.torque_ripple import TorqueRipple
from hsr_pin.robots.causes.transmission_hysteresis import TransmissionHysteresis
from hsr_pin.robots.causes.viscous_friction import ViscousFriction

#: All causes, in the order of reports.
CAUSES: tuple[JointCause, ...] = (
    CoulombFriction(),
    StribeckFriction(),
    LoadFriction(),
    TransmissionHysteresis(),
    ViscousFriction(),
    QuadraticDamping(),
    JointSpring(),
    JointStop(),
    RotorInertia(),
    Payload(),
    LinkMass(),
    LinkInertia(),
    CentreOfMass(),
    TiltedBase(),
    JointElasticity(),
    Backlash(),
    TorqueGain(),
    TorqueBias(),
    TorqueRipple(),
    Saturation(),
    DeadTime(),
    DriveLag(),
    EncoderOffset(),
    EncoderGain(),
    EncoderEccentricity(),
)
