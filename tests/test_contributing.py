"""CONTRIBUTING.md's five steps, followed to the letter in a copy of the project."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]
BLOCK = re.compile(
    r"^```(?:python|xml|bibtex)\n(?:# |<!-- |% )(\S+?\.(?:py|mlx|bib))(?: \((sort in|append)\))?(?: -->)?\n(.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the project in which every code block of the five steps stands in the file that it names."""
    copy = tmp_path_factory.mktemp("contribution") / "pymeshfair"
    copy.mkdir()
    for name in ("filters", "plugins", "mlx_scripts", "src", "docs", "tools", "tests", "pyproject.toml"):
        source = PROJECT / name
        if source.is_dir():
            # Compiled kernels go along: they are as old as their sources, which are copied with their times.
            shutil.copytree(source, copy / name, symlinks=True, ignore=shutil.ignore_patterns("*.pyc", "*.egg-info"))
        else:
            shutil.copy(source, copy / name)
    blocks = BLOCK.findall((PROJECT / "CONTRIBUTING.md").read_text(encoding="utf-8"))
    assert len(blocks) == 6
    for name, how, code in blocks:
        file = copy / name
        if how == "append":
            file.write_text(file.read_text(encoding="utf-8") + "\n" + code, encoding="utf-8")
            continue
        if how == "sort in":
            file.write_text(with_lines(file.read_text(encoding="utf-8"), code), encoding="utf-8")
            continue
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("x", encoding="utf-8") as opened:
            opened.write(code)
    return copy


def with_lines(text: str, part: str) -> str:
    """The text of a module with the imports and the public names of a part, each in its alphabetical place."""
    lines = text.splitlines()
    for line in part.splitlines():
        for kind in ("from .", '    "'):
            if line.startswith(kind):
                lines.insert(next(i for i, other in enumerate(lines) if other.startswith(kind) and other > line), line)
    return "\n".join(lines) + "\n"


def run(project: Path, *arguments: str) -> str:
    """What Python prints in the copy, with the copy's packages before the installed ones."""
    environment = {
        **os.environ,
        "PYTHONPATH": f"{project / 'src'}{os.pathsep}{project}",
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONUTF8": "1",
    }
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=project,
        env=environment,
        capture_output=True,
        encoding="utf-8",
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_the_proof_of_step_three_and_the_contracts_pass(project: Path) -> None:
    """The example's own test passes where step 3 puts it, and so do the contracts of all filters, which find it by themselves."""
    pytest_of = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "hc_smoothing or test_hc")
    passed = re.search(r"^(\d+) passed", run(project, *pytest_of, "tests/filters/test_hc.py", "tests/contracts"), re.MULTILINE)
    assert passed is not None
    assert int(passed[1]) > 30


def test_the_new_files_pass_the_checks_of_code(project: Path) -> None:
    """What the steps add passes ruff and the strict type checker as it stands."""
    for tool in ("ruff", "mypy"):
        pytest.importorskip(tool)
    written = [
        "filters/diffusion/hc.py",
        "filters/diffusion/__init__.py",
        "plugins/smoothing.py",
        "tests/filters/test_hc.py",
    ]
    for command in (["check", "--fix"], ["format"], ["check"], ["format", "--check"]):
        run(project, "-m", "ruff", *command, "--no-cache", *written)
    if (PROJECT / ".mypy_cache").is_dir():  # files that have not changed need not be checked again
        shutil.copytree(PROJECT / ".mypy_cache", project / ".mypy_cache")
    run(project, "-m", "mypy", "-m", "pymeshfair.filters.diffusion.hc", "-m", "pymeshfair.plugins.smoothing")


def test_the_new_filter_is_a_method_a_script_step_and_known_to_the_command(project: Path, tmp_path: Path) -> None:
    """After the five steps the filter works in all three places that CONTRIBUTING.md names."""
    program = (
        "import numpy as np, pymeshlab, pymeshfair\n"
        "ms = pymeshfair.MeshSet()\n"
        "ms.add_mesh(pymeshlab.Mesh(np.array([[16.0, 0, 0], [-8, 24, 0], [-8, -24, 0]]), np.array([[0, 1, 2]])))\n"
        "ms.apply_coord_hc_smoothing(iterations=1)\n"
        "print(ms.current_mesh().vertex_matrix().tolist())\n"
    )
    assert json.loads(run(project, "-c", program)) == [[-2, 0, 0], [1, -3, 0], [1, 3, 0]]  # 1 - 9/4 / 2
    described = json.loads(run(project, "-m", "pymeshfair", "info", "apply_coord_hc_smoothing", "--json"))
    assert described["filter"]["name"] == "HC Smoothing (Vollmer)"
    mesh, cleaned = tmp_path / "mesh.off", tmp_path / "smooth.off"
    mesh.write_text("OFF\n3 1 0\n0 0 0\n100 0 0\n0 33.3 0\n3 0 1 2\n")
    run(project, "-m", "pymeshfair", "run", "smooth_hc", str(mesh), "-o", str(cleaned))
    assert cleaned.exists()


def test_step_five_writes_the_new_filter_into_stubs_and_pages(project: Path) -> None:
    """The command of step 5 makes the stubs and the reference name the new filter."""
    run(project, "tools/generate.py")
    assert "apply_coord_hc_smoothing" in (project / "src/pymeshfair/meshset/filter_methods.pyi").read_text(encoding="utf-8")
    assert "apply_coord_hc_smoothing" in (project / "docs/filters.md").read_text(encoding="utf-8")
