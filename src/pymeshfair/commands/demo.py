"""``pymeshfair demo``: the main job on a real range map that the pymeshlab wheel carries."""

import importlib.util
import sys
from pathlib import Path
from typing import Annotated

import typer

from .options import Json
from .run import carry_out
from .streams import say

_RECIPE = "clean_range_map"
_SCAN = Path("tests/sample_meshes/rangemaps/face000.ply")


def demo(
    folder: Annotated[Path, typer.Option("--output", "-o", metavar="FOLDER", help="Where to write.")] = Path("pymeshfair_demo"),
    json: Json = False,
) -> None:
    """Clean a real range map, and say what to try next.

    It is the face of 85,849 vertices from a laser scanner that the pymeshlab wheel carries. FOLDER gets a copy of it, face.ply,
    and the result, face_clean.ply, in place of that of an earlier demo.
    """
    from shlex import quote

    from ..running.supervise import run_job, workers_of_runs

    with workers_of_runs() as workers:
        workers.prepare()
        from ..files.errors import OutputError
        from ..files.writing import write_file
        from ..recipe import load_recipe
        from ..running.job import Job

        scan = sample_scan()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(folder, error.strerror or str(error)) from error
        if not (folder / "face.ply").exists():
            write_file(folder / "face.ply", scan.read_bytes(), overwrite=False)
        say(f"cleaning {scan} with the recipe {_RECIPE}", err=True)
        job = Job(load_recipe(_RECIPE), scan, folder / "face_clean.ply", command=tuple(sys.argv))
        carry_out(job, lambda show: run_job(job, show, workers=workers), json=json)
    say(
        f"\nTry next:\n  pymeshfair info {_RECIPE}\n"
        f"  pymeshfair run {_RECIPE} {quote(str(scan))} -o {quote(str(folder / 'smoother.ply'))} --set detail_size=10edge\n"
        f"  pymeshfair list recipes",
        err=True,
    )


def sample_scan() -> Path:
    """The range map in the folder of pymeshlab, which is found without importing it."""
    from ..files.errors import InputError

    spec = importlib.util.find_spec("pymeshlab")
    if spec is None or spec.origin is None:
        raise InputError(_SCAN, "pymeshlab is not installed; `python -m pip install pymeshlab` installs it with this scan")
    scan = Path(spec.origin).parent / _SCAN
    if not scan.is_file():
        raise InputError(
            scan, "this pymeshlab came without its samples; the wheels of pymeshlab 2025.7 and later on PyPI have them"
        )
    return scan
