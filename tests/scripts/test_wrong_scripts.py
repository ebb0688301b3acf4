"""45 scripts that pymeshlab loads and applies without a word, or hangs or dies on: each gets the right verdict with its line."""

from __future__ import annotations

import codecs

import pytest

from pymeshfair.scripts import parse_script
from tests.scripts.texts import one_filter, problems, script, taubin

GOOD = taubin('<Param type="RichInt" name="stepSmoothNum" value="3"/>')
HEAD = b"<!DOCTYPE FilterScript>\n"


def smoothing(value: str) -> bytes:
    """A number of steps, on line 4."""
    return taubin(f'<Param type="RichInt" name="stepSmoothNum" value="{value}"/>')


def amount(value: str, kind: str = "RichFloat") -> bytes:
    """A factor, on line 4."""
    return taubin(f'<Param type="{kind}" name="lambda" value="{value}"/>')


def condition(text: str) -> bytes:
    """A selection by an expression, on line 4."""
    return one_filter("Conditional Vertex Selection", f'<Param type="RichString" name="condSelect" value="{text}"/>')


def subset(text: str) -> bytes:
    """A document type with a subset, on line 1."""
    return f"<!DOCTYPE FilterScript [{text}]>\n<FilterScript><filter name='Taubin Smooth'/></FilterScript>".encode()


LAUGHS = '<!ENTITY a "ha">' + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
METHOD = '<Param type="RichEnum" name="method" value="{}" enum_cardinality="2"/>'
LAYER = '<Param type="RichMesh" name="TargetMesh" value="{}"/>'

#: name, script, and the line and a part of the message of a problem
REFUSED: list[tuple[str, bytes, int, str]] = [
    ("empty_file", b"", 1, "not well-formed"),
    ("empty_script", HEAD + b"<FilterScript/>", 2, "has no <filter>"),
    ("not_xml", b"Taubin Smooth\n", 1, "not well-formed"),
    ("unclosed", HEAD + b"<FilterScript>\n<filter name='Taubin Smooth'>\n", 4, "not well-formed"),
    ("trunc", GOOD[: len(GOOD) // 2], 4, "not well-formed"),
    ("mismatched", HEAD + b"<FilterScript>\n<filter name='Taubin Smooth'>\n</FilterScript>", 4, "mismatched tag"),
    ("garbage", bytes(range(1, 128)), 1, "not well-formed"),
    ("binary_nul", GOOD.replace(b"Taubin", b"Tau\0bin"), 3, "not well-formed"),
    ("wrong_root", b"<Script><filter name='Taubin Smooth'/></Script>", 1, "begins with <Script>"),
    ("billion_laughs", subset(LAUGHS), 1, "document type with more than its name"),
    ("quadratic_blowup", subset(f'<!ENTITY a "{"x" * 100_000}">'), 1, "document type with more than its name"),
    ("xxe_file", subset('<!ENTITY x SYSTEM "file:///etc/passwd">'), 1, "document type with more than its name"),
    ("xxe_param_entity", subset('<!ENTITY % x SYSTEM "file:///etc/passwd"> %x;'), 1, "document type with more than its name"),
    ("xxe_http", subset('<!ENTITY x SYSTEM "http://localhost/">'), 1, "document type with more than its name"),
    ("unknown_filter", one_filter("No Such Filter"), 3, "no filter of that name"),
    ("filter_noname", script("<filter/>"), 3, "has no name"),
    ("unknown_param", taubin('<Param type="RichFloat" name="zzz" value="1"/>'), 4, "no such parameter"),
    ("unknown_type", amount("0.5", "RichNothing"), 4, "has the type RichFloat"),
    ("type_mismatch", amount("1", "RichInt"), 4, "has the type RichFloat"),
    ("int_text", smoothing("three"), 4, "takes a whole number"),
    ("int_empty", smoothing(""), 4, "takes a whole number"),
    ("int_neg", smoothing("-3"), 4, "from 0"),
    ("int_overflow", smoothing("99999999999"), 4, "from 0"),
    ("int_huge", smoothing("2000000000"), 4, "from 0"),
    ("float_nan", amount("nan"), 4, "takes a number"),
    ("float_inf", amount("inf"), 4, "takes a number"),
    ("float_comma", amount("0,3"), 4, "takes a number"),
    ("float_text", amount("half"), 4, "takes a number"),
    ("bool_text", taubin('<Param type="RichBool" name="Selected" value="maybe"/>'), 4, "true or false"),
    ("dup_param", taubin(*['<Param type="RichFloat" name="lambda" value="0.5"/>'] * 2), 5, "given twice"),
    ("no_value", taubin('<Param type="RichFloat" name="lambda"/>'), 4, "attribute value is missing"),
    ("enum_oor", one_filter("Repair non Manifold Edges", METHOD.format(77)), 4, "number of a choice"),
    ("enum_bad", one_filter("Repair non Manifold Edges", METHOD.format("Split")), 4, "number of a choice"),
    ("nested_filter", taubin('<filter name="Taubin Smooth"/>'), 4, "unknown here"),
    ("deep_nest", HEAD + b"<FilterScript>" + b"<a>" * 100_000, 2, "64 deep"),
    ("xmlfilter", script('<xmlfilter name="Compute Geometric Measures"/>'), 3, "of MeshLab 2016"),
    ("latin1", one_filter("Maß").decode().encode("latin-1"), 3, "is not UTF-8 text"),
    ("huge_value", amount("1" * 1_000_000), 4, "takes a number"),
    ("many_filters", script(*['<filter name="Taubin Smooth"/>'] * 1001), 1003, "more than 1000 filters"),
    ("mesh_ref_oor", one_filter("Vertex Attribute Transfer", LAYER.format(-1)), 4, "the id of a layer"),
    ("expr_inject", condition("__import__('os')"), 4, "no expression"),
    ("expr_bad", condition("x &gt; "), 4, "no expression"),
]

ACCEPTED = {
    "ok_taubin": GOOD,
    "bom": codecs.BOM_UTF8 + GOOD,
    "utf16": GOOD.decode().encode("utf-16"),
}


@pytest.mark.parametrize(("data", "line", "message"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED])
def test_a_wrong_script_is_refused_with_its_line(data: bytes, line: int, message: str) -> None:
    """A problem at the line where the script goes wrong says what is wrong."""
    found = problems(data)
    assert [problem.line for problem in found if message in problem.message][:1] == [line], found[:3]


@pytest.mark.parametrize("name", ACCEPTED)
def test_a_right_script_is_read(name: str) -> None:
    """A byte order mark and UTF-16 do not matter."""
    assert parse_script(ACCEPTED[name], "a").steps[0].values == {"stepsmoothnum": 3}


def test_there_are_45_scripts() -> None:
    """As many as pymeshlab was asked about."""
    assert len(REFUSED) + len(ACCEPTED) == 45
