"""Registration of the environments in Gymnasium, which happens when this module is imported.

Gymnasium imports it itself for ``gymnasium.make("hsr_pin.control.registration:hsr_pin/ReachTip-v0")``.
"""

from __future__ import annotations

from contextlib import suppress

from hsr_pin.errors import MissingDependencyError

#: Id -> entry points of the environment and of its vector environment.
ENVIRONMENTS = {
    "hsr_pin/FollowTip-v0": ("hsr_pin.control.environment:FollowTip", "hsr_pin.control.vector:FollowTips"),
    "hsr_pin/ReachTip-v0": ("hsr_pin.control.environment:ReachTip", "hsr_pin.control.vector:ReachTips"),
}


def register() -> None:
    """Register the environments for ``gymnasium.make`` and ``gymnasium.make_vec``; repeated calls have no effect.

    Raises:
        MissingDependencyError: Gymnasium is not installed.
    """
    try:
        import gymnasium
    except ImportError as error:
        raise MissingDependencyError("gymnasium", "gym") from error
    for name, (single, many) in ENVIRONMENTS.items():
        if name not in gymnasium.registry:
            gymnasium.register(name, entry_point=single, vector_entry_point=many)


with suppress(MissingDependencyError):
    register()
