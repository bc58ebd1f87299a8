"""What can be a little off in a dataset that is one nonetheless: most of these pass the reader and reach what comes after."""

from __future__ import annotations

from random import Random

from .drafts import Draft
from .mutations import _change, _columns, _rows


def number_of_the_arm(draft: Draft, random: Random) -> None:
    section = random.choice([each for each in draft.sections() if each])
    numbers = [key for key, value in section.items() if key != "format" and _is_real(value)]
    if numbers:
        key = random.choice(numbers)
        section[key] = repr(float(section[key]) * random.choice((0.5, 0.9, 0.999, 1.0001, 1.2, 3.0)))


def lengths_of_sections(draft: Draft, random: Random) -> None:
    sections, by = [table for head, table in draft.more if head == "[[section]]"], random.uniform(-0.09, 0.09)
    for table, way in zip(sections, (1, -1), strict=False):
        table["length"] = repr(float(table["length"]) + way * by)


def stiffness_of_levels(draft: Draft, random: Random) -> None:
    for trial in draft.trials:
        if "keq" in trial:
            trial["keq"] = random.choice(("1.11", "1.1100001", "1.5", "0.02", "90"))


def torsion(draft: Draft, random: Random) -> None:
    if "bending" in draft.robot:
        draft.robot["torsion"] = random.choice(("0", "1e-3", "0.8", "50", "1e6"))


def place_of_a_marker(draft: Draft, random: Random) -> None:
    marker = random.choice(draft.markers)
    marker["arc_length"] = repr(random.choice((0.0, 1e-6, 0.1, 0.2399, 0.24)))
    if "radius" in marker:
        marker["radius"], marker["angle"] = repr(random.choice((0.0, 1e-9, 0.05, 0.24))), repr(random.uniform(-7.0, 7.0))


def gain_of_inputs(draft: Draft, random: Random) -> None:
    for head, table in draft.more:
        if head == "[[input]]":
            table["gain"], table["angle"] = repr(random.choice((-0.4, 0.0, 0.01, 0.5))), repr(random.uniform(-7.0, 7.0))


def measured_input(draft: Draft, random: Random) -> None:
    places = [place for place, (head, _) in enumerate(draft.more) if head == "[[input]]"]
    if places:
        place = random.choice(places)
        columns = draft.more[place][1]["columns"]
        draft.more[place] = "[[measured]]", {"columns": columns, "unit": '"bar"'}


def input_form(draft: Draft, random: Random) -> None:
    random.choice([draft.robot, *draft.trials])["input"] = random.choice(('"held"', '"interpolated"'))


def markers_scaled(draft: Draft, random: Random) -> None:
    rows, factor = _rows(draft, random), random.choice((0.0, 0.95, 0.999, 1.02, -1.0))
    _change(rows, _columns(rows, random, random.choice(("tip", "mid", "base"))), lambda value: factor * value)


def markers_moved(draft: Draft, random: Random) -> None:
    rows, by = _rows(draft, random), random.choice((1e-5, 1e-3, -4e-3))
    _change(rows, _columns(rows, random, random.choice(("tip", "mid", "base"))), lambda value: value + by)


def markers_rounded(draft: Draft, random: Random) -> None:
    digits = random.choice((1, 2, 3, 4))
    for rows in draft.tables.values():
        _change(
            rows, [place for place, name in enumerate(rows[0]) if name[-2:] in ("_x", "_y", "_z")], lambda x: round(x, digits)
        )


def command_scaled(draft: Draft, random: Random) -> None:
    rows, factor = _rows(draft, random), random.choice((0.0, 0.5, 1.1, 2.0))
    _change(rows, _columns(rows, random, random.choice(("tau", "P", "Q"))), lambda value: factor * value)


def few_fields_missing(draft: Draft, random: Random) -> None:
    rows = _rows(draft, random)
    for place in _columns(rows, random, random.choice(("tip", "mid", "base"))):
        for row in random.sample(rows[1:], 3):
            row[place] = ""


def end_missing(draft: Draft, random: Random) -> None:
    rows = _rows(draft, random)
    del rows[random.choice((12, 25, 39)) :]


def times_from_elsewhere(draft: Draft, random: Random) -> None:
    by = random.choice((-0.5, 1e-7, 3.0, 1e4))
    for rows in draft.tables.values():
        _change(rows, [0], lambda value: value + by)


def _is_real(value: str) -> bool:
    try:
        float(value)
    except ValueError:
        return False
    return True


#: By name, in the order of the file.
SLIGHT = {
    name: change
    for name, change in list(globals().items())
    if callable(change) and getattr(change, "__module__", "") == __name__ and not name.startswith("_")
}
