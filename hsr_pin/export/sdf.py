"""Export to SDF (http://sdformat.org), the format of Gazebo and Drake."""

from __future__ import annotations

from hsr_pin.export.bodies import bodies_of
from hsr_pin.export.file import Exported
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.plain import friction, held, missing
from hsr_pin.export.templating import render
from hsr_pin.robot.urdf import SLIGHT


def to_sdf(model: CorrectedModel) -> Exported:
    """Return the model as an SDF with springs, dampers and friction, but without laws of effects."""
    bodies = bodies_of(model)
    lost = missing(model, bodies, springs=True)
    kept = held(model)
    text = render("arm.sdf.jinja", model=model, bodies=bodies, friction=friction(model), held=kept, missing=lost, slight=SLIGHT)
    return Exported(text, held=kept, missing=lost, needs=("a reader of SDF 1.7 or later for the frames of the markers",))
