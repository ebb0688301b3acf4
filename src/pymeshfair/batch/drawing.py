"""The page of one scan, and the small picture of it on the page of the batch: made in a process of its own, as a run is."""

import json
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from ..files.errors import InputError
from ..files.provenance import read_provenance
from ..files.staging import clear_up, staging_folder
from ..files.writing import StagedFile, check_target, place, stage_file
from ..processes.order import Order
from ..processes.pool import Lender
from ..running.plain_values import plain
from .journal import digests_of

#: the folder of pages, in that of the batch
PAGES = "reports"
#: pixels of a small picture
_SMALL = 128


def page_path(folder: Path, output: Path) -> Path:
    """The path of the page of a scan: ``reports/scan.ply.html`` in the folder of the batch, for its output ``scan.ply``."""
    place = output.relative_to(folder)
    return folder / PAGES / place.with_name(f"{place.name}.html")


def draw(input: Path, output: Path, page: Path, *, memory: int | None, overwrite: bool, workers: Lender) -> dict[str, Any]:
    """Write the page of a scan that was done; its small picture. Both are taken from what was written before if nothing changed.

    Returns:
        ``"source"``, the picture as a ``data:`` address, ``"width"`` and ``"height"`` in pixels.

    Raises:
        RunError: a file cannot be read or must not be replaced, or the process died.
    """
    record = read_provenance(output)
    if record is None:
        raise InputError(output, "no provenance says what it was made from")
    digests, kept = digests_of(record), page.with_suffix(".json")
    page.parent.mkdir(parents=True, exist_ok=True)
    former = _former(kept)
    if page.exists() and former.pop("digests", None) == digests:
        return former
    check_target(kept, ("json",), overwrite=overwrite or bool(former))
    check_target(page, ("html",), overwrite=overwrite or bool(former))
    with staging_folder(page) as stage:
        order = Order.of(_drawn, input, output, stage, memory_limit=memory, if_lost=partial(clear_up, stage, page))
        with workers.lend() as worker:
            answer = worker.do(order)
        if answer.error is not None:
            raise answer.error
        small: dict[str, Any] = answer.result
        known = stage_file(stage / "new" / "small.json", kept, json.dumps({"digests": digests, **small}).encode())
        place([known, StagedFile(stage / "new" / "page.html", page)], stage)
    return small


def _former(kept: Path) -> dict[str, Any]:
    """The digests and picture of a page that was made before; empty if there is none."""
    try:
        found = json.loads(kept.read_bytes())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) and {"digests", "source", "width", "height"} <= found.keys() else {}


def _drawn(input: Path, output: Path, stage: Path) -> dict[str, Any]:
    """Write the page into the staging folder; the small picture."""
    from ..looking.comparison import compare
    from ..looking.mesh_state import state_of
    from ..looking.picture import Appearance, draw_meshes
    from ..report.comparison_page import Compared, comparison_page, verdict_of
    from ..report.page import figure_of
    from ..running.read import read_mesh

    meshes = [read_mesh(path, allow_outside=True, unchecked=True) for path in (input, output)]
    before, after = map(state_of, meshes)
    found, distances = compare(before, after)
    found = replace(found, displacement=None)  # how far vertices moved is what the run said
    record = read_provenance(output)
    assert record is not None
    change = record["measures"]["change"] or {}
    page = comparison_page(
        Compared(before, after, found, distances, {}),
        title=f"{meshes[0].path.name}: {record['recipe']['name']}",
        subtitle=f"The recipe {record['recipe']['name']} on {meshes[0].path.name}, written to {output.name}.",
        numbers={"change": change, "comparison": plain(asdict(found))},
        verdict=verdict_of(found, change, record["measures"]["unit"]),
        unit=record["measures"]["unit"],
        warnings=record["warnings"],
        left_out=["No spectrum: `pymeshfair spectrum` tells it."],
        run=record,
        provenance=json.dumps(record, indent=2, ensure_ascii=False),
    )
    (stage / "new" / "page.html").write_bytes(page)
    picture = draw_meshes([read.mesh for read in meshes], ["", ""], Appearance(width=_SMALL, height=_SMALL, titles=False))
    small = figure_of(picture, "", "")
    return {"source": small.source, "width": small.width, "height": small.height}
