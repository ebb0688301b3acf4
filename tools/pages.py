"""The pages that follow from the code.

``docs/filters.md`` comes from the declarations and the bibliography, ``docs/recipes.md`` from the head comments of the recipes,
``docs/old_scripts.md`` from the facts about former filters, ``docs/documents.md`` from the schemas of what commands print.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from unicodedata import normalize

from pymeshfair.declaration import Filter, Parameter, Percentage, nearest
from pymeshfair.errors import UnknownNameError
from pymeshfair.meshlab.facts import Former, former_filters, parameter_facts
from pymeshfair.recipe import TASKS, load_recipe, shipped_heads, shipped_recipes
from pymeshfair.registry import custom_filters

DOCS = Path(__file__).parents[1] / "docs"
BIBLIOGRAPHY = DOCS / "bibliography.bib"
#: LaTeX's accents as those of Unicode that follow their letter
ACCENTS = {'"': "\u0308", "'": "\u0301", "`": "\u0300", "v": "\u030c"}


def filters_page() -> str:
    """The reference of every filter that pymeshfair declares."""
    own = [f for f in custom_filters() if f.origin == "pymeshfair"]
    parts = [
        "# Filters\n",
        "Each is a method of `pymeshfair.MeshSet`, a step of an .mlx script under its menu name, and known to `pymeshfair info`. "
        "Written by `python tools/generate.py pages` from the declarations.\n",
        "Lengths are `'1%'` of the bounding box's diagonal, `'0.5edge'` (mean edges) or `'0.3'` (mesh units); pymeshlab's "
        "`PercentageValue` and `PureValue` work too.\n",
        *(f"* [{f.name}](#{f.python_name}): {f.summary}" for f in own),
        "",
        *(filter_section(f) for f in own),
    ]
    return "\n".join(parts)


def filter_section(declared: Filter) -> str:
    """One filter: what it does, its parameters as a table, its sources."""
    lines = [f'<a id="{declared.python_name}"></a>\n## {declared.name}\n', f"`{declared.python_name}`\n", f"{declared.info}\n"]
    if declared.parameters:
        lines += ["| parameter | allowed | default | meaning |", "|---|---|---|---|"]
        lines += [f"| `{p.name}` | {allowed(p)} | `{p.default}` | {p.help} |" for p in declared.parameters]
        lines.append("")
    if declared.references:
        lines += ["Sources: " + "; ".join(cited(declared.references, declared.python_name)) + ".\n"]
    return "\n".join(lines)


def allowed(parameter: Parameter) -> str:
    """What the parameter takes, without the words about lengths that head the page."""
    if isinstance(parameter, Percentage):
        return "a length"
    return parameter.describe_allowed().replace("|", "\\|")


def cited(keys: Iterable[str], filter_name: str) -> list[str]:
    """Authors, title and year of each key that a filter cites, from the bibliography.

    Raises:
        UnknownNameError: the bibliography has no such key.
    """
    text = BIBLIOGRAPHY.read_text(encoding="utf-8")
    entries = {match[1]: match[2] for match in re.finditer(r"@\w+\{(\w+),(.*?)\n\}", text, re.DOTALL)}
    for key in keys:
        if key not in entries:
            near = nearest(key, entries)
            hint = f"; did you mean {near!r}?" if near else ""
            raise UnknownNameError(f"{BIBLIOGRAPHY} has no entry {key!r}, which {filter_name} cites{hint}", suggestion=near)
    return [_citation(entries[key]) for key in keys]


def _citation(entry: str) -> str:
    authors = _value(entry, "author").replace(" and ", "; ")
    return f"{authors}: *{_value(entry, 'title')}*, {_value(entry, 'year')}"


def _value(entry: str, key: str) -> str:
    found = re.search(rf"\b{key}\s*=\s*\{{(.*)\}},?\n", entry + "\n")
    if found is None:
        raise ValueError(f"the bibliography entry has no {key}: {entry}")
    text = re.sub(r"""\{\\(["'`v])\{?(\w)\}?\}""", lambda accent: normalize("NFC", accent[2] + ACCENTS[accent[1]]), found[1])
    return re.sub(r"[{}]", "", text)


#: What the benchmark of recipes found, and how it compares.
RECIPES_COMPARED = Path(__file__).with_name("recipes_compared.md").read_text("utf-8")


def _tasks() -> list[str]:
    """A row for each task with links to its recipes."""
    rows = []
    for task in TASKS:
        names = [head.name for head in shipped_heads() if head.info.task == task]
        rows.append(f"| {task} | {', '.join(f'[{name}](#{name})' for name in names)} |")
    return rows


def recipes_page() -> str:
    """What each shipped recipe is for, does and lets the user tune, with its steps."""
    parts = [
        "# Recipes\n",
        "`pymeshfair run NAME scan.ply -o clean.ply`; `--set SETTING=VALUE` sets what a recipe names, and "
        "`--set STEP.PARAM=VALUE` any parameter. Written by `python tools/generate.py pages` from the scripts' "
        "head comments; the pictures, before and after, by `python tools/recipe_pictures.py` from samples of pymeshlab and "
        "generated shapes. Superseded recipes still run, and say what to take instead: "
        + ", ".join(f"`{name}`" for name in shipped_recipes(superseded=True))
        + ".\n",
        RECIPES_COMPARED,
        "| task | recipes |",
        "|---|---|",
        *_tasks(),
        "",
    ]
    return "\n".join([*parts, *map(recipe_section, shipped_recipes())])


def recipe_section(name: str) -> str:
    """One recipe: its head comment, its picture, its settings and its steps."""
    recipe = load_recipe(name)
    lines = [f'<a id="{name}"></a>\n## {name}\n', f"**{recipe.title}**\n", f"{recipe.description}\n"]
    lines.append(f"![Before and after {name}](pictures/recipes/{name}.png)\n")
    if recipe.script.settings:
        lines += ["| setting | default | unit | meaning |", "|---|---|---|---|"]
        lines += [f"| `{s.name}` | `{s.default}` | {s.unit} | {s.description} |" for s in recipe.script.settings]
        lines.append("")
    lines.append("Steps:\n")
    lines += [f"{i}. {step.filter.name}" for i, step in enumerate(recipe.script.steps, start=1)]
    return "\n".join([*lines, ""])


#: what each command prints with --json, as JSON Schema
DOCUMENTS = Path(__file__).parents[1] / "src/pymeshfair/commands/documents.json"


def documents_page() -> str:
    """What each command prints with --json, key by key."""
    schemas = json.loads(DOCUMENTS.read_text("utf-8"))
    parts = [
        "# JSON documents\n",
        "With `--json` every command prints one document on stdout, and messages on stderr. If it fails, the document has the "
        "key `error`. Paths are as typed, but absolute in `batch` and for files that `run` writes; unknown numbers are null. "
        "The schemas are in [documents.json](../src/pymeshfair/commands/documents.json) (JSON Schema 2020-12); tests hold every "
        "document to them. Written by `python tools/generate.py pages` from there. [Exit codes](command_line.md#exit-codes).\n",
    ]
    for name, schema in schemas["commands"].items():
        parts += [f"## {name}\n", f"{schema['description']}\n", *_keys(schema), ""]
    parts.append("# Parts of documents\n")
    for name, schema in schemas["$defs"].items():
        parts += [f'<a id="{_anchor(name)}"></a>', f"## {name}\n", f"{schema['description']}\n", *_keys(schema), ""]
    return "\n".join(parts)


def _keys(schema: dict[str, Any], before: str = "") -> list[str]:
    """A table row for each key; those of an object within it follow under ``key.``, those of a list under ``key[].``."""
    rows = [] if before else ["| key | type | meaning |", "|---|---|---|"]
    for name, value in schema.get("properties", {}).items():
        key = before + name + ("[]" if value.get("type") == "array" else "")
        inner = value.get("items", value)
        meaning = value.get("description", "")
        if inner is not value and inner.get("description"):
            meaning = f"{meaning} {inner['description']}".strip()
        rows.append(f"| `{key}` | {_type(value)} | {meaning} |")
        rows += _keys(inner, f"{key}.")
    return rows


def _type(schema: dict[str, Any]) -> str:
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{_anchor(name)})"
    if "anyOf" in schema:
        return " or ".join(_type(choice) for choice in schema["anyOf"])
    if "enum" in schema:
        return ", ".join(f"`{word}`" for word in schema["enum"])
    if schema["type"] == "array" and "items" in schema:
        return f"list of {_type(schema['items'])}"
    kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    return " or ".join(kinds)


def _anchor(name: str) -> str:
    return name.replace(" ", "-")


OLD_SCRIPTS = """\
# Scripts of older MeshLab versions

`pymeshfair upgrade OLD.mlx -o NEW.mlx` brings a script up to date and lists every change; `pymeshfair run --upgrade` does
so for one run. If a change alters the meaning of the script, the list says how, and the change must be accepted by `--accept`; a
run lists it among its warnings. Written by `python tools/generate.py pages` from the table of facts.

Besides names, an upgrade turns `<xmlfilter>` into `<filter>`, gives every value the type of its parameter (`RichPoint3f` is
`RichPosition` or `RichDirection` today), corrects the case of names, and leaves out a second document type and comments after
the head. The tables have every filter in MeshLab's sources since 2009; capital letters and blanks in names do not count.
A value without a type is left out, as MeshLab ignores it, and so is a parameter that no version has, which must be accepted.
Two changes do not show in the names:

* In MeshLab 2016 Screened Poisson, Poisson-disk Sampling and Montecarlo Sampling did not change the current layer; today
  their result is current. A Delete Current Mesh right after them deleted the input and would delete the result: it is left out.
* After Close Holes the new faces are selected, and a step without `Selected` works only on them: it gets `Selected=false`.

`--relative-to MESH` makes the lengths of a script for one mesh relative to the size of that mesh before their step (the steps
before it are run). Each changed length is listed.

Of 44 scripts of 2010 to 2025 from public repositories 42 are brought up to date, 31 of them without a change of meaning,
and 40 run on a mesh that comes with pymeshlab; two ask for filters that are gone, two for photographs
(`python benchmarks/old_scripts.py FOLDER`).

Whether the meaning is the same was measured in plain pymeshlab: of 120 scripts, one for each old name, 97 give the same bits on
three meshes as the old filter, none gives others, and 23 need what these meshes or the machine lack, such as textures and cameras
(`python benchmarks/upgraded_meaning.py`).

[The other way](writing_recipes.md#export), to MeshLab's desktop and plain pymeshlab, goes `pymeshfair export`.
"""


def old_scripts_page() -> str:
    """What became of the filters and parameters of older MeshLab versions."""
    filters = [f"| `{old}` | {_today(former)} | {_with(former)} |" for old, former in former_filters().items()]
    parameters = [
        f"| {name} | `{old}` | {now} |" for name, former in parameter_facts().items() for old, now in _old_parameters(former)
    ]
    return "\n".join(
        [
            OLD_SCRIPTS,
            "## Filters\n",
            "| once | today | with |",
            "|---|---|---|",
            *filters,
            "",
            "## Parameters\n",
            "| filter | once | today |",
            "|---|---|---|",
            *parameters,
            "",
        ]
    )


def _today(former: Former) -> str:
    if former.splits:
        return "; ".join(
            f"{name} ({parameter}={value})" for parameter, names in former.splits.items() for value, name in names.items()
        )
    if former.now is None:
        return "nothing: it never changed a mesh" if former.idle else "gone"
    return f"{former.now} (the old name was never MeshLab's)" if former.invented else former.now


def _with(former: Former) -> str:
    sets = ", ".join(f"`{name}={text}`" for name, text in former.sets.items())
    return "; ".join(part for part in (sets, former.note) if part)


def _old_parameters(former: Former) -> list[tuple[str, str]]:
    """Each old parameter with what says the same today."""
    rows = [(old, f"`{new}`") for old, new in former.renames.items()]
    for old, cases in former.turns.items():
        said = []
        for value, new in cases.items():
            sets = ", ".join(f"`{name}={text.replace('*', 'VALUE')}`" for name, text in new.items()) or "nothing"
            said.append(sets if value == "*" else f"{value}: {sets}")
        rows.append((old, "; ".join(said)))
    rows += [(old, f"gone: {change}") for old, change in former.loses.items()]
    rows += [(old, "gone" if same is None else f"gone; today as with {same or 'no name'}") for old, same in former.drops.items()]
    for name, new in former.newer.items():
        only = f" with {new['if']}" if "if" in new else ""
        rows.append((f"{name} missing{only}", f"`{name}={new['value']}`; {new['meaning']}"))
    return rows


PAGES = {
    "filters.md": filters_page,
    "recipes.md": recipes_page,
    "old_scripts.md": old_scripts_page,
    "documents.md": documents_page,
}
