"""Text labels as objects of a meshcat scene."""

from __future__ import annotations

import io
from typing import Any

from hsr_pin.replay.viewer import geometry as mg


def label(text: str, colour: str, height: float) -> tuple[Any, Any]:
    """Return geometry and material of a thin box in the x-y plane with a text that is readable from positive z.

    Args:
        text: one line of text.
        colour: colour in the notation of Matplotlib.
        height: height of the box [m]; its width follows from the text.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 0.6), dpi=160)
    written = figure.text(0.5, 0.5, text, ha="center", va="center", fontsize=24, color=colour, weight="bold")
    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    box = written.get_window_extent(renderer)
    figure.set_size_inches(1.06 * box.width / figure.dpi, 1.5 * box.height / figure.dpi)
    picture = io.BytesIO()
    figure.savefig(picture, format="png", transparent=True)
    width, tall = figure.get_size_inches()
    texture = mg.ImageTexture(mg.PngImage(picture.getvalue()))
    material = mg.MeshBasicMaterial(map=texture, transparent=True, side=0)  # one-sided, as the back would show the text mirrored
    return mg.Box([height * width / tall, height, 1e-4 * height]), material
