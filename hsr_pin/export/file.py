"""What an export is: texts, and an honest list of what they hold."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hsr_pin.errors import OutputError
from hsr_pin.output import check_writable, write_text


@dataclass(frozen=True, eq=False)
class Exported:
    """One model in one format.

    Attributes:
        text: of the file.
        module: Python source that belongs beside it; empty: nothing is needed.
        held: what the file expresses, beside bodies, springs and dampers, one sentence each.
        by_module: what the module does.
        missing: what neither does.
        needs: how the file must be used, one sentence each.
    """

    text: str
    module: str = ""
    held: tuple[str, ...] = ()
    by_module: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()


def module_path(path: str | Path) -> Path:
    """Where the module of a file stands: ``arm.xml`` has ``arm_laws.py`` beside it.

    Raises:
        OutputError: the name of the file does not make the name of a module.
    """
    target = Path(path)
    stem = f"{target.stem}_laws"
    if not stem.isidentifier():
        hint = "a module of Python is written beside it, and named after it"
        raise OutputError("name of the file", expected="letters, digits and _", received=target.name, hint=hint)
    return target.with_name(f"{stem}.py")


def write(exported: Exported, path: str | Path) -> list[str]:
    """Write the file, and the module if there is one; their names.

    Raises:
        OutputError: one of them cannot be written.
    """
    if not exported.module:
        write_text(path, exported.text)
        return [str(path)]
    beside = module_path(path)
    check_writable(path)
    write_text(beside, exported.module)
    write_text(path, exported.text)
    return [str(path), str(beside)]
