"""Pages of the site that are no files of docs/: the start, and one for every filter and every recipe. A hook of mkdocs.

Pages that exist in docs/ stay as they are; links to files outside of docs/ become words.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

sys.path.insert(0, str(Path(__file__).parent))
import pages

from pymeshfair import Recipe
from pymeshfair.commands.info import as_written
from pymeshfair.declaration import Arity, Filter, Mesh
from pymeshfair.recipe import load_recipe, shipped_heads, shipped_recipes
from pymeshfair.registry import custom_filters
from pymeshfair.scripts import format_script

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
#: files of the project's own folder that are pages
TOP = {"README.md": "index.md", "CONTRIBUTING.md": "CONTRIBUTING.md", "CHANGELOG.md": "CHANGELOG.md"}
PICTURES = ROOT / "docs/pictures/filters"
#: what an example does first, so that the filter has something to work on
PREPARATIONS = {
    "apply_coord_region_fairing": 'ms.compute_selection_by_condition_per_vertex(condselect="x > 1.5")',
    "apply_scalar_anisotropic_diffusion_per_vertex": "ms.compute_scalar_by_mean_curvature_per_vertex()",
}


def own_filters() -> list[Filter]:
    """The filters that have a page."""
    return [f for f in custom_filters() if f.origin == "pymeshfair"]


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Add the pages of filters and recipes to the menu."""
    sections = {title: pages for part in config.nav or [] for title, pages in part.items() if isinstance(pages, list)}
    sections["Use"].append({"Each recipe": [{head.info.title: f"recipes/{head.name}.md"} for head in shipped_heads()]})
    sections["Filters"].append({"Each filter": [{f.name: f"filters/{f.python_name}.md"} for f in own_filters()]})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the files of these pages."""
    from mkdocs.structure.files import File  # tests of the pictures have no mkdocs

    for source, page in TOP.items():
        text = (ROOT / source).read_text("utf-8")
        head = "---\nsearch:\n  exclude: true\n---\n" if source == "CHANGELOG.md" else ""  # the search finds what is true today
        files.append(File.generated(config, page, content=head + re.sub(r"\]\(docs/", "](", text)))
    for declared in own_filters():
        files.append(File.generated(config, f"filters/{declared.python_name}.md", content=filter_page(declared)))
    for name in shipped_recipes():
        files.append(File.generated(config, f"recipes/{name}.md", content=recipe_page(name)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Links to the project's own folder go to the pages that its files have become, or are words."""
    if "/" in page.file.src_uri:
        return markdown
    for source, target in TOP.items():
        markdown = markdown.replace(f"](../{source}", f"]({target}")
    return re.sub(r"\[([^\]]*)\]\(\.\./[^)]*\)", r"\1", markdown)


def filter_page(declared: Filter) -> str:
    """A filter: what it does, a picture, its parameters, its sources, and how it is called."""
    name = declared.python_name
    section = re.sub(r"<a id=.*\n## ", "# ", pages.filter_section(declared))
    title, _, rest = section.partition("\n")
    picture = (
        f"![Before and after {declared.name}](../pictures/filters/{name}.png)\n" if (PICTURES / f"{name}.png").exists() else ""
    )
    return "\n".join([title, "", picture, rest, *examples(declared)])


def examples(declared: Filter) -> list[str]:
    """The lines of examples that do the same."""
    return [
        "## In Python\n",
        f"```python\n{python_example(declared)}```\n",
        "## In a script, and by the command\n",
        f"```xml\n{script_example(declared)}```\n",
        "```\npymeshfair check step.mlx\npymeshfair run step.mlx scan.ply -o result.ply\n```\n",
    ]


def python_example(declared: Filter) -> str:
    """A program that loads a scan, applies the filter and saves the result, with one of the parameters written out."""
    arguments = ""
    for parameter in [p for p in declared.parameters if not isinstance(p, Mesh)][:1]:
        arguments = f"{parameter.name}={as_written(parameter.default)!r}"
    other = ""
    if declared.arity != Arity.SINGLE_MESH or any(isinstance(p, Mesh) for p in declared.parameters):
        other = 'ms.load_new_mesh("other.ply")\nms.set_current_mesh(0)\n'
    if preparation := PREPARATIONS.get(declared.python_name):
        other += f"{preparation}\n"
    call = f"ms.{declared.python_name}({arguments})"
    last = f"print({call})" if declared.python_name.startswith("get_") else f'{call}\nms.save_current_mesh("result.ply")'
    return f'from pymeshfair import MeshSet\n\nms = MeshSet()\nms.load_new_mesh("scan.ply")\n{other}{last}\n'


def script_example(declared: Filter) -> str:
    """The step as a script that holds all its parameters, as MeshLab writes them."""
    recipe = Recipe()
    recipe.apply_filter(declared.python_name)
    return format_script(recipe.script)


def recipe_page(name: str) -> str:
    """A recipe, as on the page of all, with the command that runs it."""
    section = re.sub(r"<a id=.*\n## .*\n", "", pages.recipe_section(name)).replace("](pictures/", "](../pictures/")
    commands = f"pymeshfair info {name}\npymeshfair run {name} scan.ply -o clean.ply"
    return f"# {load_recipe(name).title}\n\n`{name}`\n\n{section}\n```\n{commands}\n```\n"
