"""Recordings of hardware with a cause withheld that is known.

- ``build``: a case from a recipe
- ``edits``: what is done to a recording, or to what is declared of it
- ``recipes``: which recording, which trials, which edit, and what the truth then is
"""
