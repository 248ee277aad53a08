"""Text files from anybody: read within limits, in the encodings that editors and shells write."""

import codecs
import json
import stat
from pathlib import Path
from typing import Any

from llsrbm.errors import FileFormatError, InputError, printable

_WIDE = (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32")
_MARKS = (*_WIDE, (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_PIPED = ("/dev/stdin", "/dev/fd/", "/proc/self/fd/")  # what a shell makes of `-` and `<(...)`


def path_of(path: Any) -> Path:
    """A path as `Path`; raises `InputError` unless it is text or a `Path`."""
    if not isinstance(path, str | Path):
        raise InputError(f"expected a path as text or a Path, got {type(path).__name__}")
    return Path(path)


def read_text(
    path: str | Path,
    what: str,
    largest: int,
    error: type[InputError] = FileFormatError,
    *,
    piped: bool = False,
) -> str:
    """The text of a file of at most `largest` bytes; `what` names it, with an article, in messages.

    `piped`: whether a shell's pipe may stand in its place.

    Raises `error`: one line that names the file and what is wrong with it.
    """
    there = path_of(path)  # messages name it as it was written
    try:
        kind = there.stat().st_mode  # before it is opened: a pipe would be waited for
        if stat.S_ISDIR(kind):
            raise error(f"{path}: cannot be read (it is a folder); expected {what}")
        if not stat.S_ISREG(kind) and not (piped and str(path).startswith(_PIPED)):
            raise error(f"{path}: cannot be read (not a regular file); expected {what}")
        with there.open("rb") as file:
            content = file.read(largest + 1)
    except (OSError, ValueError) as reason:  # ValueError: a name that no file can have
        why = reason.strerror if isinstance(reason, OSError) else str(reason)
        raise error(f"{path}: cannot be read ({why}); expected {what}") from reason
    if len(content) > largest:
        raise error(f"{path}: too large for {what}; expected at most {largest} bytes")
    return decoded(content, str(path), what, error)


def decoded(
    content: bytes, where: str, what: str, error: type[InputError] = FileFormatError
) -> str:
    """A file's bytes as text: UTF-8, or UTF-16 or UTF-32 with their mark. Errors as `read_text`."""
    if not content.strip():
        raise error(f"{where}: an empty file; expected {what}")
    coding = next((name for mark, name in _MARKS if content.startswith(mark)), "utf-8-sig")
    try:
        return content.decode(coding)
    except UnicodeDecodeError as reason:
        raise error(f"{where}: not a text file in UTF-8; expected {what}") from reason


def parse_json(text: str, where: str) -> Any:
    """The content of a JSON text with finite numbers and every key once; `where` names it. Raises
    `FileFormatError`: one line.
    """
    try:
        return json.loads(text, object_pairs_hook=_without_duplicates, parse_constant=_no_constant)
    except InputError as reason:
        raise FileFormatError(f"{where}: {reason}") from reason
    except RecursionError as reason:
        raise FileFormatError(f"{where}: not a JSON file: nested too deeply") from reason
    except ValueError as reason:  # JSONDecodeError, or a number of thousands of digits
        why = str(reason).partition("; use sys.")[0]
        raise FileFormatError(f"{where}: not a JSON file: {printable(why, 200)}") from reason


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for name, value in pairs:
        if name in table:
            named = printable(json.dumps(name))
            raise InputError(f"{named} appears twice; expected every key once")
        table[name] = value
    return table


def _no_constant(word: str) -> float:
    raise InputError(f"expected finite numbers, got {word}")
