"""Laws of the plants: the physics that the nominal model may lack.

- ``actuation``: actuator_lag, dead_time, torque_bias, torque_decay, torque_map
- ``dissipative``: damping_gradient, dry_friction, hysteresis, quadratic_damping, viscoelastic
- ``elastic``: backlash, bending_stop, soft_spot, stiffening, stiffness_gradient
- ``forms``: laws of the catalogue in forms that are not the catalogue's own
- ``law``: what a law can change
- ``mounting``: added_mass, gravity_tilt, marker_offset, tip_mass
- ``outside``: laws outside of the catalogue
- ``session``: changes of plain parameters between recordings
"""

from __future__ import annotations

from types import ModuleType

import numpy as np

from hsr_pin.errors import EffectError

from . import actuation, dissipative, elastic, mounting, outside, session
from .forms import actuation as actuation_forms
from .forms import damping as damping_forms
from .forms import elastic as elastic_forms
from .forms import friction as friction_forms
from .forms import mounting as mounting_forms
from .law import Law


def _laws_in(*modules: ModuleType) -> dict[str, type[Law]]:
    """Return the laws that some modules define, by name or ``name:variant``."""
    found = [
        each
        for module in modules
        for each in vars(module).values()
        if isinstance(each, type) and issubclass(each, Law) and each.__module__ == module.__name__
    ]
    return dict(sorted((f"{law.name}:{law.variant}" if law.variant else law.name, law) for law in found))


CATALOGUE = _laws_in(actuation, dissipative, elastic, mounting)
OUTSIDE = _laws_in(outside)
#: Laws of the catalogue in other forms, by ``name:variant``.
FORMS = _laws_in(actuation_forms, damping_forms, elastic_forms, friction_forms, mounting_forms)
#: Laws for changes of the arm's plain parameters between two recordings.
PARAMETERS = _laws_in(session)


def draw(name: str, rng: np.random.Generator) -> Law:
    """Return a law of any list by its name or ``name:variant``, with random secondary parameters and moderate strength."""
    laws = {**CATALOGUE, **OUTSIDE, **FORMS, **PARAMETERS}
    if name not in laws:
        raise EffectError("law", expected=" or ".join(sorted(laws)), received=name)
    return laws[name].draw(rng)
