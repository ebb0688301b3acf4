"""Reads XML that comes from anywhere: without entities, within limits, and to its end.

What MeshLab's readers are given is written anew from the elements, so that no other parser can understand it otherwise.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree import ElementTree
from xml.parsers import expat

from .errors import ContentsError

#: levels of elements within elements; a scene of a program has some ten
_DEEPEST = 200
#: elements of a document that is kept as a tree: so many take two seconds and 300 MB
_MOST_ELEMENTS = 500_000


def parse_xml(
    data: bytes,
    start: Callable[[str, dict[str, str]], object],
    end: Callable[[str], object] = lambda tag: None,
    text: Callable[[str], object] = lambda text: None,
) -> None:
    """Go through a document.

    Args:
        data: the whole of it.
        start: called with the name, prefix included, and the attributes of every element.
        end: called with the name of each when it ends.
        text: called with the text between.

    Raises:
        ContentsError: it is not well-formed, declares entities, or is nested too deeply.
    """
    depth = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise ContentsError(f"it has elements more than {_DEEPEST} levels deep")
        start(tag, attributes)

    def finish(tag: str) -> None:
        nonlocal depth
        depth -= 1
        end(tag)

    def refuse_subset(name: str, system: str | None, public: str | None, has_subset: int) -> None:
        if has_subset:
            raise ContentsError("it declares entities or a document type of its own, which no mesh needs")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse_subset
    parser.StartElementHandler = begin
    parser.EndElementHandler = finish
    parser.CharacterDataHandler = text
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise ContentsError(f"its line {error.lineno:,} is no XML: {expat.ErrorString(error.code)}") from None
    except ContentsError:
        raise
    except (LookupError, ValueError):
        raise ContentsError("it is written in an encoding that is not known; save it as UTF-8") from None


def read_tree(data: bytes) -> ElementTree.Element:
    """The document as a tree; names of elements keep their prefixes.

    Raises:
        ContentsError: see `parse_xml`; or it has too many elements.
    """
    builder = ElementTree.TreeBuilder()
    count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > _MOST_ELEMENTS:
            raise ContentsError(f"it has more than {_MOST_ELEMENTS:,} elements")
        builder.start(tag, attributes)

    parse_xml(data, start, builder.end, builder.data)
    return builder.close()


def formatted_tree(root: ElementTree.Element) -> bytes:
    """The document as UTF-8, without comments, instructions and document type."""
    text: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text
