"""The text of a URDF: its bytes read as XML says, without anything that other files would add."""

from __future__ import annotations

import codecs
import re
import xml.etree.ElementTree as ET
from pathlib import Path

from llsrbm.errors import RobotFileError, printable

_MARKS = (  # a longer mark before the one that it begins with
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECLARED = re.compile(rb"""\s*<\?xml[^>]*?encoding\s*=\s*["']([^"']*)["']""")
_LARGEST = 64 * 2**20  # bytes of a URDF


class _Refused(Exception):
    pass


class _Builder(ET.TreeBuilder):
    """Builds no tree of a file with a document type: its entities may be files, or endless."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise _Refused(f"it has a document type <!DOCTYPE {name}>; expected none, nor entities")


def read_xml(path: Path, where: str, kind: str = "a URDF") -> ET.Element:
    """The root element of a URDF or an SRDF, `kind`; `where`: how messages begin. Raises
    `RobotFileError`: it cannot be read, is in another encoding than it says, or is none.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RobotFileError(f"{where} cannot be read: {error.strerror}") from error
    if len(content) > _LARGEST:
        raise RobotFileError(f"{where} is not {kind}: it has {len(content)} bytes")
    text = _decoded(content, where, kind)
    parser = ET.XMLParser(target=_Builder())  # noqa: S314  no entities get past the builder
    try:
        parser.feed(text)
        root: ET.Element = parser.close()
    except (ET.ParseError, _Refused) as error:
        raise RobotFileError(f"{where} is not {kind}: {error}") from error
    _strip_namespace(root)
    if root.tag != "robot":
        raise RobotFileError(
            f"{where} is not {kind}: it begins with <{printable(root.tag)}>; expected <robot>"
        )
    return root


def _decoded(content: bytes, where: str, kind: str) -> str:
    encoding = next((name for mark, name in _MARKS if content.startswith(mark)), "")
    declared = _DECLARED.match(content)
    if not encoding:
        encoding = declared.group(1).decode("latin-1") if declared else "utf-8"
    try:
        return content.decode(encoding)
    except LookupError as error:
        raise RobotFileError(
            f'{where} is not {kind}: no encoding is called "{printable(encoding)}"; expected '
            "utf-8, or the one that its first line names"
        ) from error
    except UnicodeError as error:
        line = content.count(b"\n", 0, getattr(error, "start", 0)) + 1
        named = "its first line names no other" if not declared else "as its first line has it"
        raise RobotFileError(
            f'{where} is not {kind}: line {line} is not in the encoding "{encoding}" ({named}); '
            'expected that, or another in <?xml version="1.0" encoding="..."?>'
        ) from error


def _strip_namespace(root: ET.Element) -> None:
    """Names without the namespace that the whole file has, if it has one."""
    if not root.tag.startswith("{"):
        return
    own = root.tag.partition("}")[0] + "}"
    for element in root.iter():
        if isinstance(element.tag, str):
            element.tag = element.tag.removeprefix(own)
