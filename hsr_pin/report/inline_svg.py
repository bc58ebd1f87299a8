"""Matplotlib figures as inline SVG, with the colours of the page's style sheet (light, dark, print) and text kept as text."""

from __future__ import annotations

import html
import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Role -> placeholder colour that matplotlib draws with; :func:`inline` replaces it by the CSS variable ``--role``.
ROLES = {
    "ink": "#010203",
    "faint": "#010204",
    "grid": "#010205",
    "declared": "#010206",
    "model": "#010207",
    "measured": "#010208",
    "bar": "#010209",
    "noise": "#01020a",
}

#: Width of a page [inch].
_WIDTH = 7.4
_STYLE: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "hsr_pin",
    "text.parse_math": False,  # names of users may contain dollar signs
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.edgecolor": ROLES["faint"],
    "axes.labelcolor": ROLES["ink"],
    "axes.titlecolor": ROLES["ink"],
    "text.color": ROLES["ink"],
    "xtick.color": ROLES["faint"],
    "ytick.color": ROLES["faint"],
    "xtick.labelcolor": ROLES["ink"],
    "ytick.labelcolor": ROLES["ink"],
    "grid.color": ROLES["grid"],
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.5,
}


@contextmanager
def drawing() -> Iterator[None]:
    """Apply the matplotlib style of report figures within a ``with`` block."""
    import matplotlib

    with matplotlib.rc_context(_STYLE):
        yield


@contextmanager
def page_figure(height: float) -> Iterator[Figure]:
    """Yield a figure as wide as a page with a height [inch], which is drawn in the style of reports within a ``with`` block."""
    from matplotlib.figure import Figure

    with drawing():
        yield Figure(figsize=(_WIDTH, height), layout="constrained")


def inline(figure: Figure, name: str, description: str) -> str:
    """Return a figure as an ``<svg>`` element that fills the width of its container.

    Args:
        figure: a figure drawn in the colours of :data:`ROLES`.
        name: prefix of every id, so that one page can contain several figures.
        description: text alternative for readers who cannot see the figure.
    """
    content = io.StringIO()
    with drawing(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)  # the font of the page has the glyph
        figure.savefig(
            content, format="svg", transparent=True, metadata={"Date": None, "Creator": None, "Format": None, "Type": None}
        )
    text = content.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>|<style .*?</style>", "", text, flags=re.DOTALL)
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'(url\(#|href="#)', rf"\g<1>{name}-", text)
    for role, colour in ROLES.items():
        text = text.replace(colour, f"var(--{role})")
    text = text.replace("'DejaVu Sans'", "'DejaVu Sans', Verdana")
    return text.replace("<svg", f'<svg role="img" aria-label="{html.escape(description)}"', 1)
