"""XML text -> element tree with line numbers, for files from untrusted sources.

Only the standard library's expat is used. A document type declaration (and with it every entity, internal or external) is
rejected, so that nothing is fetched and nothing is expanded.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from hsr_pin.errors import UrdfError


@dataclass(frozen=True, eq=False)
class XmlTree:
    """A parsed XML document with the positions of its elements.

    Attributes:
        root: the outermost element.
        positions: line and column of each element, from 1.
        source: the file, for messages.
    """

    root: Element
    positions: dict[Element, tuple[int, int]]
    source: str | Path | None

    def fail(
        self, subject: str, at: Element | None = None, *, expected: str, received: object = None, hint: str = ""
    ) -> NoReturn:
        """Raise a :class:`UrdfError` at an element (the root by default)."""
        line, column = self.positions[self.root if at is None else at]
        raise UrdfError(
            subject, expected=expected, received=received, hint=hint, file=self.source or "URDF", line=line, column=column
        )


def parse_xml(text: str, source: str | Path | None = None) -> XmlTree:
    """Parse an XML document.

    Raises:
        UrdfError: the text is not XML, or declares a document type; the error has line and column.
    """
    builder = TreeBuilder()
    positions: dict[Element, tuple[int, int]] = {}
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = builder.start(tag, attributes)
        positions[element] = parser.CurrentLineNumber, parser.CurrentColumnNumber + 1

    def refuse(*_: object) -> None:
        raise UrdfError(
            "a document type declaration",
            expected="XML without <!DOCTYPE>, as hsr-urdf writes it",
            hint="remove it",
            file=source or "URDF",
            line=parser.CurrentLineNumber,
            column=parser.CurrentColumnNumber + 1,
        )

    parser.StartElementHandler, parser.EndElementHandler = start, builder.end
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
    except (expat.ExpatError, UnicodeError) as error:
        raise UrdfError(
            "not XML",
            expected="a complete URDF file",
            received=expat.ErrorString(error.code) if isinstance(error, expat.ExpatError) else error,
            hint="write a new one with hsr-urdf",
            file=source or "URDF",
            line=getattr(error, "lineno", None),
            column=error.offset + 1 if isinstance(error, expat.ExpatError) else None,
        ) from error
    return XmlTree(builder.close(), positions, source)
