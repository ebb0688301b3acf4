"""Reads XML from untrusted sources: entities are refused, depth and size are limited."""

from collections.abc import Callable
from xml.etree import ElementTree
from xml.parsers import expat

from .errors import ContentsError

#: levels of nested elements; usual scenes have about ten
_DEEPEST = 200
#: the most elements of a tree; they take two seconds and 300 MB
_MOST_ELEMENTS = 500_000


def parse_xml(
    data: bytes,
    start: Callable[[str, dict[str, str]], object],
    end: Callable[[str], object] = lambda tag: None,
    text: Callable[[str], object] | None = None,
) -> None:
    """Call functions for the elements, their ends and the text of a document without entities; names have their prefixes."""
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
    """The document as a tree; names of elements have no prefixes."""
    builder = ElementTree.TreeBuilder()
    count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > _MOST_ELEMENTS:
            raise ContentsError(f"it has more than {_MOST_ELEMENTS:,} elements")
        builder.start(tag.rpartition(":")[2], attributes)

    parse_xml(data, start, lambda tag: builder.end(tag.rpartition(":")[2]), builder.data)
    return builder.close()
