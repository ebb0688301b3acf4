"""What commands print with --json has the form that its schema says, and every command has a schema."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from tests.running.runs import BONE

from .command_line import SCHEMAS, fits, invoke
from .test_app import all_commands

#: by schema, a command line that prints such a document, and its exit code
PRINTED = {
    "run": ("run smooth_taubin scan.ply -o again.ply --map map.ply --max-displacement 0.001edge --keep-broken", 1),
    "batch": ("batch smooth_taubin scan.ply missing.ply -o outs", 1),
    "batch --dry-run": ("batch smooth_taubin scan.ply -o outs --dry-run", 0),
    "verify": ("verify out.ply", 0),
    "check": ("check smooth_taubin wrong.mlx", 2),
    "export": ("export smooth_taubin -o exported.mlx", 0),
    "upgrade": ("upgrade plain.mlx -o new.mlx", 0),
    "list filters": ("list filters taubin", 0),
    "list recipes": ("list recipes", 0),
    "info FILTER": ("info apply_coord_normal_filtering", 0),
    "info RECIPE": ("info denoise", 0),
    "info MESH": ("info scan.ply", 0),
    "suggest": ("suggest scan.ply", 0),
    "spectrum": ("spectrum scan.ply", 0),
    "compare": ("compare scan.ply out.ply --tolerance 0.000001% --no-self-intersections", 1),
    "picture": ("picture scan.ply -o picture.png", 0),
    "doctor": ("doctor", 0),
}
#: serves a page until it is interrupted; tests/browser reads its document
ENDLESS = {"tune"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a scan, a result of it, a script and one that is not valid."""
    place = tmp_path_factory.mktemp("documents")
    shutil.copy(BONE, place / "scan.ply")
    (place / "wrong.mlx").write_text("<FilterScript><filter name='Taubin'/></FilterScript>")
    for line in (f"run smooth_taubin {place}/scan.ply -o {place}/out.ply", f"export smooth_taubin -o {place}/plain.mlx"):
        assert invoke(*line.split()).exit_code == 0
    return place


@pytest.mark.slow
@pytest.mark.parametrize("name", PRINTED)
def test_a_document_has_the_form_of_its_schema(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is one document of that form, without a key that the schema lacks."""
    monkeypatch.chdir(folder)
    line, code = PRINTED[name]
    done = invoke(*line.split(), "--json")
    read = json.loads(done.stdout)
    assert done.exit_code == code, done.stderr
    assert "error" not in read or name in ("check", "upgrade")
    assert fits(read, name), next(Draft202012Validator(SCHEMAS["commands"][name] | {"$defs": SCHEMAS["$defs"]}).iter_errors(read))
    assert not fits({**read, "another": 1}, name)


def test_every_command_has_a_schema() -> None:
    """`demo` prints what `run` prints; `info` has three forms."""
    there = {name.partition(" ")[2].split(" -")[0] for name in (f"x {name}" for name in SCHEMAS["commands"])}
    commands = {name.removeprefix("pymeshfair ") for name in all_commands()}
    assert commands - {"demo", "info"} <= there
    assert set(PRINTED) | ENDLESS == set(SCHEMAS["commands"])
    Draft202012Validator.check_schema({"$defs": SCHEMAS["$defs"] | SCHEMAS["commands"]})
