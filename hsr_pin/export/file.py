"""Result of an export: the texts of its files, and lists of what they contain and lack."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hsr_pin.errors import OutputError
from hsr_pin.output import check_writable, write_text


@dataclass(frozen=True, eq=False)
class Exported:
    """Model in one format.

    Attributes:
        text: content of the file.
        module: source of the Python module beside the file; empty: no module is needed.
        held: contents of the file in addition to bodies, springs and dampers, one sentence each.
        by_module: effects that the module applies, one sentence each.
        missing: effects that neither contains, one sentence each.
        needs: requirements for the use of the file, one sentence each.
    """

    text: str
    module: str = ""
    held: tuple[str, ...] = ()
    by_module: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()


def module_path(path: str | Path) -> Path:
    """Return the path of the module of a file: ``arm_laws.py`` beside ``arm.xml``.

    Raises:
        OutputError: no valid module name can be made from the name of the file.
    """
    target = Path(path)
    stem = f"{target.stem}_laws"
    if not stem.isidentifier():
        hint = "the Python module beside the file is named after it"
        raise OutputError("name of the file", expected="letters, digits and _", received=target.name, hint=hint)
    return target.with_name(f"{stem}.py")


def write(exported: Exported, path: str | Path) -> list[str]:
    """Write the file and, if there is one, the module; return their names.

    Raises:
        OutputError: a file cannot be written.
    """
    if not exported.module:
        write_text(path, exported.text)
        return [str(path)]
    beside = module_path(path)
    check_writable(path)
    write_text(beside, exported.module)
    write_text(path, exported.text)
    return [str(path), str(beside)]
