"""Damages of a tree of tables, lists and values, such as JSON and TOML hold: one node of it is another, or gone."""

from __future__ import annotations

import copy
from random import Random
from typing import Any

#: What is put in place of a node.
ODD = (
    None, True, 0, -1, 1e300, -1e-300, 10**400, float("nan"), float("inf"), -float("inf"), 2.5, 1e6, "", " ", "1.11", "x",
    "\x1b[31m", "a\nb", "\ud800", "漢字", "]]>", "<b>", "a--b", "x" * 5000, [], [1], [[]], [None], {}, {"a": 1}, {"value": None},
    {"keq": 1},
)  # fmt: skip


def damaged(tree: Any, random: Random) -> Any:
    """A copy with a damage or a few, or with numbers that are a little off: many of these are read."""
    tree = copy.deepcopy(tree)
    if random.random() < 0.5:
        for _ in range(random.randint(1, 3)):
            holder, key = random.choice([place for place in _places(tree) if _is_number(place[0][place[1]])])
            holder[key] *= random.choice((0.0, 0.5, 0.999, 1.0001, 1.2, 3.0, -1.0))
        return tree
    for _ in range(random.choice((1, 1, 2, 3))):
        places = list(_places(tree))
        if places:
            random.choice((_replace, _replace, _remove, _rename, _repeat, _spell))(*random.choice(places), random)
    return tree


def _places(node: Any):
    """Every table and list, with each of the keys to what it holds."""
    if isinstance(node, dict | list):
        for key in list(node) if isinstance(node, dict) else range(len(node)):
            yield node, key
            yield from _places(node[key])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _spell(holder: Any, key: Any, random: Random) -> None:
    if isinstance(value := holder[key], str):
        holder[key] = random.choice((value.upper(), f" {value}", value[:-1], f"{value}{value}"))


def _replace(holder: Any, key: Any, random: Random) -> None:
    holder[key] = copy.deepcopy(random.choice(ODD))


def _remove(holder: Any, key: Any, random: Random) -> None:
    del holder[key]


def _rename(holder: Any, key: Any, random: Random) -> None:
    if isinstance(holder, dict):
        holder[random.choice((f"{key}@1.11", f"{key}s", str(key).upper(), "", "a.b", "keq_scale"))] = holder.pop(key)


def _repeat(holder: Any, key: Any, random: Random) -> None:
    if isinstance(holder, list):
        holder.append(copy.deepcopy(holder[key]))
