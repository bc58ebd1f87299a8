"""What can be wrong with a dataset, or odd: each changes a draft in one way that its random numbers choose."""

from __future__ import annotations

from random import Random

from .drafts import Draft

#: Numbers as TOML has them, which few arms have.
NUMBERS = (
    "0", "-0.0", "-1", "1", "1e-300", "5e-324", "1e-9", "1e9", "1e300", "1" + "0" * 400, "nan", "inf", "-inf", "240", "0.00024",
    "true", '"0.15"', "[0.1]", "{a = 1}", "1979-05-27", "0x10", "1_0", "3.14159",
)  # fmt: skip
#: Texts as TOML has them.
TEXTS = (
    '""',
    '" "',
    '"$x$"',
    '"[/]"',
    '"<b>"',
    '"a,b"',
    '"\\u001b[31m"',
    '"../x"',
    '"漢字"',
    '"' + "x" * 5000 + '"',
    "1",
    '"base"',
    '"_"',
)
#: Fields of a table.
FIELDS = (
    "",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e30",
    "1e-320",
    "x",
    "0x10",
    "1_0",
    "1,5",
    '"',
    "\uff11",
    " 1 ",
    "\0",
    "-",
    "0",
    "true",
    "NaN",
)
#: On whole columns.
FACTORS = (0.0, -1.0, 0.001, 1000.0, 100.0, 1e6, 1e-9, 1.5)
#: On times. Milliseconds are an item of their own; what is longer would want more memory than there is, and waits for it too.
TIME_FACTORS = (0.001, 0.1, 10.0, 1000.0)


def value_of_a_key(draft: Draft, random: Random) -> None:
    section = random.choice([each for each in draft.sections() if each])
    key = random.choice(list(section))
    section[key] = random.choice(TEXTS if section[key].startswith('"') and random.random() < 0.8 else NUMBERS)


def key_missing(draft: Draft, random: Random) -> None:
    section = random.choice([each for each in draft.sections() if each])
    del section[random.choice(list(section))]


def key_more(draft: Draft, random: Random) -> None:
    names = ("damping", "keq", "tip_mass", "t_start", "lenght", "note", '"é"', "a.b", "mount", "links")
    random.choice(draft.sections())[random.choice(names)] = random.choice((*NUMBERS, *TEXTS))


def release_time(draft: Draft, random: Random) -> None:
    for trial in draft.trials:
        trial["t_start"] = random.choice(("0", "0.1", "0.5", "0.9", "0.974", "0.975", "2", "-1", "nan"))


def section_twice(draft: Draft, random: Random) -> None:
    sections = random.choice([draft.markers, draft.trials])
    if sections:
        sections.append(dict(random.choice(sections)))


def section_missing(draft: Draft, random: Random) -> None:
    sections = random.choice([draft.markers, draft.trials])
    if sections:
        del sections[random.randrange(len(sections))]


def marker_place(draft: Draft, random: Random) -> None:
    if draft.markers:
        random.choice(draft.markers)["arc_length"] = random.choice(("0", "1e-6", "0.004", "0.12", "0.24", "0.2400001", "0.3"))


def mount(draft: Draft, random: Random) -> None:
    draft.robot["mount"] = random.choice(('"upright"', '"horizontal"', '"sideways"', '"Hanging"'))


def damping(draft: Draft, random: Random) -> None:
    for trial in draft.trials:
        trial["damping"] = random.choice(("0", "1e-6", "0.001", "5", "1e4"))


def bytes_of_a_file(draft: Draft, random: Random) -> None:
    name, at, byte = random.choice(["dataset.toml", *draft.tables]), random.random(), random.randrange(256)
    changes = (
        lambda data: data[: int(at * len(data))],
        lambda data: b"",
        lambda data: b"\xef\xbb\xbf" + data,
        lambda data: data.replace(b"\n", b"\r\n"),
        lambda data: data.replace(b"\n", b"\r"),
        lambda data: data[: int(at * len(data))] + bytes([byte]) + data[int(at * len(data)) + 1 :],
        lambda data: data + data,
        lambda data: data.replace(b",", b";"),
        lambda data: data.decode("utf-8", "replace").encode("utf-16"),
        lambda data: bytes(reversed(data)),
    )
    draft.texts.append((name, random.choice(changes)))


def _rows(draft: Draft, random: Random) -> list[list[str]]:
    """Of some trial, which has a header and a row at least."""
    return random.choice([rows for rows in draft.tables.values() if len(rows) > 1 and rows[0]] or [[["t"], ["0"]]])


def _columns(rows: list[list[str]], random: Random, prefix: str = "") -> list[int]:
    """Some of those whose name begins so."""
    found = [place for place, name in enumerate(rows[0]) if name.startswith(prefix)]
    return [place for place in found if random.random() < 0.5] or found[:1]


def _change(rows: list[list[str]], columns: list[int], change) -> None:
    for row in rows[1:]:
        for place in columns:
            try:
                row[place] = f"{change(float(row[place])):.9g}"
            except (IndexError, ValueError, OverflowError):
                continue


def field_odd(draft: Draft, random: Random) -> None:
    rows = _rows(draft, random)
    row = random.choice(rows)
    if row:
        row[random.randrange(len(row))] = random.choice(FIELDS)


def fields_missing(draft: Draft, random: Random) -> None:
    rows, share = _rows(draft, random), random.choice((0.02, 0.3, 0.9, 1.0))
    for place in _columns(rows, random, random.choice(("", "tip", "mid", "t", "P"))):
        for row in rows[1:]:
            if place < len(row) and random.random() < share:
                row[place] = random.choice(("", "nan"))


def column_scaled(draft: Draft, random: Random) -> None:
    rows, factor = _rows(draft, random), random.choice(FACTORS)
    columns = _columns(rows, random, random.choice(("tip", "mid", "base", "P", "tau")))
    _change(rows, columns, lambda value: factor * value)


def column_moved(draft: Draft, random: Random) -> None:
    rows, by = _rows(draft, random), random.choice((0.001, 0.05, 1.0, -3.0, 1e5))
    _change(rows, _columns(rows, random, random.choice(("tip", "mid", "base", "P", "tau"))), lambda value: value + by)


def column_still(draft: Draft, random: Random) -> None:
    for rows in draft.tables.values() if random.random() < 0.5 else [_rows(draft, random)]:
        for place in _columns(rows, random, random.choice(("tip", "mid", "P", "tau", ""))):
            for row in rows[2:]:
                if place < len(row) and place < len(rows[1]) and place:
                    row[place] = rows[1][place]


def column_missing(draft: Draft, random: Random) -> None:
    rows = _rows(draft, random)
    place = random.randrange(len(rows[0]))
    for row in rows:
        del row[place : place + 1]


def column_more(draft: Draft, random: Random) -> None:
    name = random.choice(("tau", "P1", "t", "tip_x", "tip_w", "", "note"))
    for number, row in enumerate(_rows(draft, random)):
        row.append("0.1" if number else name)


def columns_turned(draft: Draft, random: Random) -> None:
    for row in _rows(draft, random):
        row.reverse()


def rows_missing(draft: Draft, random: Random) -> None:
    rows, left = _rows(draft, random), random.choice((0, 1, 2, 4, 5, 9, 12, 30))
    del rows[1 + left :]


def row_odd(draft: Draft, random: Random) -> None:
    rows = _rows(draft, random)
    place = random.randrange(1, len(rows))
    random.choice(
        (
            lambda: rows.insert(place, list(rows[place])),
            lambda: rows.pop(place),
            lambda: rows[place].append("1"),
            lambda: rows[place].pop(),
            lambda: rows.insert(place, []),
            lambda: rows.reverse(),
            lambda: rows.insert(place, list(rows[0])),
        )
    )()


def pause(draft: Draft, random: Random) -> None:
    rows = _rows(draft, random)
    start, length = random.randrange(1, len(rows)), random.choice((1, 3, 20))
    del rows[start : start + length]


def times_uneven(draft: Draft, random: Random) -> None:
    rows, size = _rows(draft, random), random.choice((1e-6, 1e-3, 0.01, 0.1))
    _change(rows, _columns(rows, random, "t")[:1] and [0], lambda value: value + size * random.uniform(-1, 1))


def times_scaled(draft: Draft, random: Random) -> None:
    factor = random.choice(TIME_FACTORS)
    for rows in draft.tables.values():
        _change(rows, [0], lambda value: factor * value)


def outliers(draft: Draft, random: Random) -> None:
    rows, size = _rows(draft, random), random.choice((0.02, 0.3, 1e3))
    for place in _columns(rows, random, random.choice(("tip", "mid"))):
        for row in random.sample(rows[1:], min(3, len(rows) - 1)):
            if place < len(row):
                row[place] = f"{size * random.uniform(-1, 1):.6f}"


def noise(draft: Draft, random: Random) -> None:
    rows, size = _rows(draft, random), random.choice((1e-5, 3e-3, 0.05))
    _change(rows, _columns(rows, random, "tip"), lambda value: value + random.gauss(0, size))


def file_missing(draft: Draft, random: Random) -> None:
    if draft.tables:
        draft.tables.pop(random.choice(list(draft.tables)))


def trials_alike(draft: Draft, random: Random) -> None:
    names = list(draft.tables)
    if len(names) > 1:
        draft.tables[names[1]] = [list(row) for row in draft.tables[names[0]]]


#: By name, in the order of the file.
MUTATIONS = {
    name: change
    for name, change in list(globals().items())
    if callable(change) and getattr(change, "__module__", "") == __name__ and not name.startswith("_")
}
