"""The documentation site: ``sphinx-build -W -j 2 docs build/docs`` (group ``docs``)."""

import os
import re
import sys
from pathlib import Path

import nbclient.client
import nbformat
from traitlets import Bool

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "hsr_pin"
author = "The hsr_pin developers"
copyright = author

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon", "effect_pictures", "formulas"]
exclude_patterns = ["_*"]
templates_path = ["_templates"]

html_theme = "furo"
html_title = "hsr_pin"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("effects.js", {"defer": "defer"})]
html_copy_source = False
html_show_search_summary = False  # they would have to be fetched, which pages read from a disk may not
html_math_renderer = "mathml"  # drawn by the browser: no script, nothing fetched

# Tutorials run at every build, in a process of their own, and end the build where they fail.
os.environ |= {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}", "COLUMNS": "92", "NO_COLOR": "1"}
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 180
nb_execution_show_tb = True  # and a warning, which ends the build
nb_ipywidgets_js = {}  # they would come from elsewhere
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3


class _Joined(nbclient.client.NotebookClient):
    """What a program prints in pieces is one text."""

    coalesce_streams = Bool(True)


nbclient.client.NotebookClient = _Joined

PACKAGE = Path(__file__).parents[1] / "hsr_pin"
autosummary_generate = True
#: Rooms within rooms have pages of their own: each stands in api/index.md.
autosummary_context = {
    "packages": [".".join(door.parent.relative_to(PACKAGE.parent).parts) for door in PACKAGE.rglob("__init__.py")]
}
autoclass_content = "class"
add_module_names = False
toc_object_entries_show_parents = "hide"
autodoc_member_order = "bysource"
autodoc_type_aliases = {name: name for name in ("Array", "ArrayLike")}
suppress_warnings = ["ref.python"]  # a name that stands in two rooms links to neither of them
python_maximum_signature_line_length = 60  # one argument a line beyond: telephones are narrow
napoleon_numpy_docstring = False
napoleon_use_rtype = False


def _as_written(app, what, name, obj, options, lines):  # type: ignore[no-untyped-def]
    """Bars in docstrings are absolute values; what stands before the colon in the text of a constant is no type."""
    if what in ("data", "attribute", "property") and lines and any(line.startswith(":type: ") for line in lines):
        (told,) = (line for line in lines if line.startswith(":type: "))
        lines[:] = [f"{told.removeprefix(':type: ')}: {lines[0]}", *(line for line in lines[1:] if line != told)]
    lines[:] = [re.sub(r"(``.*?``)|\|", lambda found: found[1] or r"\|", line) for line in lines]


def _without_tuple_fields(app, what, name, obj, skip, options):  # type: ignore[no-untyped-def]
    """Fields of named tuples stand in the text of their class."""
    return True if type(obj).__name__ == "_tuplegetter" else None


def _without_roles(app, error):  # type: ignore[no-untyped-def]
    """A notebook that was downloaded shows its own name, not the role by which Sphinx links to it."""
    for file in Path(app.outdir).glob("_downloads/*/*.ipynb"):
        notebook = nbformat.read(file, as_version=4)
        for cell in notebook.cells:
            cell.source = cell.source.replace("{nb-download}", "") if cell.cell_type == "markdown" else cell.source
        nbformat.write(notebook, file)


def setup(app):  # type: ignore[no-untyped-def]
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", _as_written, priority=900)  # after napoleon
    app.connect("autodoc-skip-member", _without_tuple_fields)
    app.connect("build-finished", _without_roles)
