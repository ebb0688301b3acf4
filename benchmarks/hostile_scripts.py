"""Damaged scripts, counted: how many are refused, how many are read, and how long the slowest takes.

    python benchmarks/hostile_scripts.py [FOLDER] [--count 10000] [--seed 0]

The shipped recipes, two old scripts and those in FOLDER are damaged at random, in bytes, in elements and in values. Each is read
and upgraded in this process, so that a death ends the count. A script that is read is parsed again by another XML parser, which
has to find the same filters with the same values and nothing else. Ends with 1 if a broken structure was read, an error other
than `ScriptError` came up, or a script took a second of processor time.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

import pymeshfair
from pymeshfair.declaration import Bool, Float, Int
from pymeshfair.recipe import shipped_recipes
from pymeshfair.scripts import Script, ScriptError, Step, format_script, parse_script, upgrade_script

OLD = (
    b"""<!DOCTYPE FilterScript>
<FilterScript>
<filter name="Taubin Smooth">
<Param type="RichFloat" name="lambda" value="0.25" description="d" tooltip="t"/>
<Param type="RichInt" name="stepSmoothNum" value="3"/>
</filter>
<filter name="Remove Duplicated Vertex"/>
</FilterScript>
""",
    b"""<!DOCTYPE FilterScript>
<FilterScript>
<xmlfilter name="Screened Poisson Surface Reconstruction"><xmlparam name="depth" value="6"/></xmlfilter>
<filter name="Delete Current Mesh"/>
<filter name="Compute normals for point sets">
<Param type="RichPoint3f" x="0" y="0" z="0" name="viewPos"/></filter>
</FilterScript>
""",
)
PIECES = (b"<", b">", b'"', b"&", b"/", b"\0", b"\xff", b"name", b"value", b"<filter", b"</filter>", b"<Param/>", b"]]>", b"<!--")
VALUES = (b"nan", b"inf", b"-1", b"1e999", b"9" * 400, b"", b"0,3", b"True", b"&lt;", b"&x;", b"%", b"6edges", b"\xc3\xa9")
#: processor seconds that no script may take
MOST_SECONDS = 1.0


def mutant(choose: random.Random, seeds: Sequence[bytes]) -> bytes:
    """A script with one to four places damaged."""
    data = choose.choice(seeds)
    for _ in range(choose.randint(1, 4)):
        data = choose.choice((_with_bytes, _with_bytes, _with_elements, _with_values))(choose, data)
    return data


def _with_bytes(choose: random.Random, data: bytes) -> bytes:
    """Some bytes deleted, doubled, overwritten or filled in."""
    start = choose.randrange(len(data) + 1)
    end = min(len(data), start + choose.choice((0, 1, 5, 40)))
    new = choose.choice((b"", data[start:end] * 2, choose.choice(PIECES), bytes([choose.randrange(256)])))
    return data[:start] + new + data[end:]


def _with_elements(choose: random.Random, data: bytes) -> bytes:
    """A tag deleted, doubled, moved or wrapped, or an attribute deleted or given twice."""
    parts = re.split(rb"(<[^<>]*>)", data)
    tags = range(1, len(parts), 2)
    if not tags:
        return data
    one, other = choose.choice(tags), choose.choice(tags)
    kind = choose.randrange(5)
    if kind == 0:
        parts[one] = b""
    elif kind == 1:
        parts[one] *= 2
    elif kind == 2:
        parts[one], parts[other] = parts[other], parts[one]
    elif kind == 3:
        parts[one] = b"<filter name='Close Holes'>" + parts[one] + b"</filter>"
    else:
        attributes = re.findall(rb'\s\w+="[^"]*"', parts[one])
        if attributes:
            gone = choose.choice(attributes)
            parts[one] = parts[one].replace(gone, choose.choice((b"", gone * 2)), 1)
    return b"".join(parts)


def _with_values(choose: random.Random, data: bytes) -> bytes:
    """The text of an attribute replaced."""
    places = list(re.finditer(rb'="([^"]*)"', data))
    if not places:
        return data
    start, end = choose.choice(places).span(1)
    return data[:start] + choose.choice(VALUES) + data[end:]


def wrong_reading(data: bytes, script: Script) -> str | None:
    """In what a script that was read differs from what another parser finds; None if in nothing."""
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        return f"is not XML: {error}"
    filters = [element for element in root if element.tag == "filter"]
    if root.tag != "FilterScript" or any(element.tag not in ("filter", "setting") for element in root):
        return "has other elements"
    if any(param.tag != "Param" or len(param) for element in root for param in element):
        return "has other elements within a filter"
    if any((element.text or "").strip() or (element is not root and (element.tail or "").strip()) for element in root.iter()):
        return "has text"
    if [element.get("name") for element in filters] != [step.filter.name for step in script.steps]:
        return "has other filters"
    return next((wrong for pair in zip(filters, script.steps, strict=True) if (wrong := _wrong_values(*pair)) is not None), None)


def _wrong_values(element: ElementTree.Element, step: Step) -> str | None:
    params = {param.get("name"): param for param in element}
    known = {p.xml_name: p for p in step.filter.parameters if p.name in step.values}
    if len(params) != len(element) or params.keys() != known.keys():
        return f"has other parameters of {step.filter.name}"
    for name, parameter in known.items():
        text, value = params[name].get("value", ""), step.values[parameter.name]
        same = {"true": True, "false": False}.get(text) is value if isinstance(parameter, Bool) else True
        if isinstance(parameter, Int | Float):
            same = float(text) == parameter.to_number(value)
        if not same:
            return f"has another {name} of {step.filter.name}"
    return None


def verdict(data: bytes) -> tuple[str, float]:
    """What becomes of a script, ``read``, ``upgraded``, ``refused`` or what is wrong, and the processor seconds that it takes."""
    started = time.process_time()
    try:
        upgraded = upgrade_script(data, "mutant").script
    except ScriptError as error:
        return "refused" if error.problems else "refused without a reason", time.process_time() - started
    except Exception as error:
        return f"{type(error).__name__} instead of ScriptError", time.process_time() - started
    try:
        script = parse_script(data, "mutant")
    except ScriptError:
        script = None
    seconds = time.process_time() - started
    again = parse_script(format_script(upgraded, known_mesh=False).encode(), "again")
    if again != upgraded.with_defaults(lengths=False):
        return "upgraded to a script that reads otherwise", seconds
    if script is None:
        return "upgraded", seconds
    return wrong_reading(data, script) or "read", seconds


def seeds(folder: Path | None) -> Iterator[bytes]:
    """The scripts that are damaged."""
    recipes = Path(pymeshfair.__file__).parent / "mlx_scripts"
    yield from OLD
    yield from ((recipes / f"{name}.mlx").read_bytes() for name in shipped_recipes())
    if folder is not None:
        yield from (path.read_bytes() for path in sorted(folder.glob("*.mlx")))


def main() -> int:
    """Count; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    choose, known = random.Random(options.seed), list(seeds(options.folder))
    for data in known:
        verdict(data)  # what is loaded once is loaded now
    count: Counter[str] = Counter()
    slowest = 0.0
    for _ in range(options.count):
        word, seconds = verdict(mutant(choose, known))
        count[word] += 1
        slowest = max(slowest, seconds)
    for word, number in count.most_common():
        print(f"{number:>7}  {word}")
    print(f"{slowest:>7.3f}  processor seconds for the slowest")
    return int(slowest > MOST_SECONDS or bool(count.keys() - {"read", "upgraded", "refused"}))


if __name__ == "__main__":
    sys.exit(main())
