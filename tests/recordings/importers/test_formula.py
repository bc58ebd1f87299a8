"""A formula of columns computes what it states, runs no code, and an invalid one says which name is wrong."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr_pin.recordings.importers.formula import Formula, FormulaError

NAMES = ("P1", "P2", "P3", "left muscle", "tip x (mm)", "P(:,2)", "a-b", "a", "b", "$4")
VALUES = dict(zip(NAMES, np.random.default_rng(2).uniform(1, 2, (len(NAMES), 5)), strict=True))


def value(text, names=NAMES):
    formula = Formula.parse(text, names)
    return formula.of(np.stack([VALUES[name] for name in formula.names], axis=1))


RIGHT = {
    "P1 - (P2 + P3) / 2": lambda v: v["P1"] - (v["P2"] + v["P3"]) / 2,
    "-left muscle": lambda v: -v["left muscle"],
    "1e-3 * tip x (mm) ** 2": lambda v: 1e-3 * v["tip x (mm)"] ** 2,
    "P(:,2) - $4/.5": lambda v: v["P(:,2)"] - v["$4"] / 0.5,
    "a-b": lambda v: v["a-b"],
    "a - b": lambda v: v["a"] - v["b"],
    "p1*pi": lambda v: v["P1"] * np.pi,
    "sqrt(abs(-P2)) + sin(P1) - cos(P3) + exp(a) + log(b)": lambda v: (
        np.sqrt(v["P2"]) + np.sin(v["P1"]) - np.cos(v["P3"]) + np.exp(v["a"]) + np.log(v["b"])
    ),
}


@pytest.mark.parametrize("text", RIGHT)
def test_a_formula_is_the_arithmetic_that_it_states(text):
    assert np.allclose(value(text), RIGHT[text](VALUES), rtol=1e-14)


WRONG = {
    "P1 - Q": "'Q'",
    "left muscl - P2": "did you mean 'left muscle'?",
    "__import__('os')": "'__import__'",
    "P1.__class__": "'.__class__'",
    "P1 if P2 else P3": "'if'",
    "P1 == P2": "'=='",
    "[P1]": "'['",
    "P1 P2": "an expression such as",
    "(P1": "an expression such as",
    "abs(P1)(P2)": "an expression such as",
    "2 * 3": "the name of a column in it",
    "P1" + "+P1" * 300: "at most 500 characters",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_no_arithmetic_of_known_names_is_refused(text):
    with pytest.raises(FormulaError) as caught:
        Formula.parse(text, NAMES)
    assert WRONG[text] in " ".join([caught.value.subject, *caught.value.facts.values()])


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(FormulaError) as caught:
        Formula.parse("P1 - Q", NAMES)
    assert all(name in caught.value.facts["hint"] for name in NAMES)


def test_upper_and_lower_case_count_where_two_names_differ_in_nothing_else():
    with pytest.raises(FormulaError, match="formula"):
        Formula.parse("A - b", ["a", "b", "B"])
    assert Formula.parse("A - b", ["a", "B"]).names == ("a", "B")


@given(st.text(alphabet="P12 +-*/().,eab_[]{}:;'\"\\\0$=<>", max_size=40))
def test_any_text_is_a_formula_or_refused(text):
    try:
        value(text)
    except FormulaError as error:
        assert error.subject.startswith("formula")


def test_a_number_that_grows_without_bounds_is_infinite_at_once():
    assert np.isinf(value("9**9**9**9 * P1")).all()
