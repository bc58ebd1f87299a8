"""Recordings of hardware with a withheld, known cause.

- ``build``: a case from a recipe
- ``edits``: edits of a recording, or of its declared values
- ``recipes``: recording, trials, edit and truth of each case
"""
