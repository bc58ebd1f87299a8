"""Export to URDF, the format of ROS, PyBullet, Drake, Isaac and most other programs."""

from __future__ import annotations

from hsr_pin.export.bodies import bodies_of
from hsr_pin.export.file import Exported
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.plain import friction, held, missing
from hsr_pin.export.templating import render
from hsr_pin.robot.urdf import SLIGHT


def to_urdf(model: CorrectedModel) -> Exported:
    """Return the model as a URDF with dampers and friction, but without springs and laws of effects."""
    bodies = bodies_of(model)
    lost = missing(model, bodies, springs=False)
    kept = held(model)
    text = render("arm.urdf.jinja", model=model, bodies=bodies, friction=friction(model), held=kept, missing=lost, slight=SLIGHT)
    needs = ("a fixed base, and the torques of springs and actuators, which must be applied to the joints in every step",)
    return Exported(text, held=kept, missing=lost, needs=needs)
