"""An error is one printable line of limited length, whatever names it contains."""

import pytest

from hsr_pin.errors import LONGEST_LIST, LONGEST_QUOTE, HsrError, InputError, one_line, printable, quoted


@pytest.mark.parametrize("character", ["\x1b", "\x07", "\x9b", "\x7f", "\u202e", "\udcff", "\0"])
def test_control_characters_and_bytes_that_are_no_text_are_escaped(character):
    error = InputError("name", expected="a text", received=f"a{character}[31mb", file=f"dir{character}/x.toml", line=3)
    assert str(error).isprintable()
    assert str(error).startswith("dir\\") and "[31mb" in str(error)


def test_a_text_that_can_be_shown_stays_as_it_is():
    text = "é°µ [/] $x$ 漢字"
    assert printable(text) == one_line(text) == text
    assert str(InputError("name", expected="a text", received=text)) == f"name: expected a text, got {text}"


def test_lines_of_a_text_stay_lines():
    assert printable("one\ntwo\x1b") == "one\ntwo\\x1b"
    assert one_line("one\n  two") == "one two"


@pytest.mark.parametrize("name", ["x" * 100_000, "long name " * 10_000, "C:\\x y " * 500])
@pytest.mark.parametrize("part", ["subject", "received", "hint", "file"])
def test_no_more_than_200_characters_of_a_name_are_quoted(name, part):
    facts = {"subject": "column", "received": "x", "hint": "none", "file": "f"} | {part: f"did you mean {name!r}?"}
    text = str(InputError(facts.pop("subject"), **facts))
    assert "did you mean" in text
    assert max(map(len, text.split("'"))) <= LONGEST_QUOTE
    assert len(text) < 2 * LONGEST_QUOTE


def test_a_list_of_names_is_cut_too():
    names = ", ".join(f"column_{number}" for number in range(100_000))
    assert len(one_line(f"known columns: {names}")) <= LONGEST_LIST
    assert one_line(f"known columns: {names}").endswith("column_99999")


def test_a_value_that_cannot_be_written_out_is_told_by_its_kind():
    assert quoted(10**5000) == "a very large int"
    assert str(InputError("links", received=10**5000)) == "links: got a very large int"
    assert len(quoted(10**4000)) <= LONGEST_QUOTE


def test_the_facts_of_an_error_stay_whole():
    error = InputError("name", expected="less", received="x" * 1000)
    assert error.received == "x" * 1000
    assert isinstance(error, HsrError)
