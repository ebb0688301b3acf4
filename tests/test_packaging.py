"""The wheel and the source distribution hold what the tree holds."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path, PurePosixPath

import pytest

ROOT = Path(__file__).parent.parent
#: the folders of the tree that become packages of the wheel
PACKAGES = {
    "src/pymeshfair": "pymeshfair",
    "filters": "pymeshfair/filters",
    "plugins": "pymeshfair/plugins",
    "mlx_scripts": "pymeshfair/mlx_scripts",
}
SHIPPED = {".py", ".mlx", ".json", ".pyi", ".typed", ".html", ".js", ".css"}
#: what only building or running leaves behind
GENERATED = shutil.ignore_patterns("__pycache__", "*.egg-info", "build", "dist", ".*_cache", ".venv*", ".git", ".hypothesis")


def shipped_files() -> set[str]:
    """The files of the tree that belong into the wheel, by their place in it."""
    found = set()
    for source, target in PACKAGES.items():
        for folder, folders, names in os.walk(ROOT / source):  # does not follow the links in src/pymeshfair
            folders[:] = [f for f in folders if f != "__pycache__"]
            inside = Path(folder).relative_to(ROOT / source)
            found |= {str(PurePosixPath(target, *inside.parts, n)) for n in names if Path(n).suffix in SHIPPED}
    return found


def requirements(wheel: Path) -> list[str]:
    """What its metadata says that it needs."""
    [name] = [name for name in zipfile.ZipFile(wheel).namelist() if name.endswith(".dist-info/METADATA")]
    lines = zipfile.ZipFile(wheel).read(name).decode().splitlines()
    return [line.removeprefix("Requires-Dist: ") for line in lines if line.startswith("Requires-Dist: ")]


def build(source: Path, target: Path, *kinds: str, kernels: str = "none") -> None:
    """Build distributions without asking the network for the build backend, and without kernels, which take a minute."""
    command = [sys.executable, "-m", "build", "--no-isolation", *kinds, "--outdir", str(target), str(source)]
    environment = {**os.environ, "PYMESHFAIR_KERNELS": kernels}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a wheel from the tree, and in ``sdist/`` a source distribution with the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("distributions")
    copy = folder / "copy"  # a build in the tree would leave files that enter the next wheel
    shutil.copytree(ROOT, copy, symlinks=True, ignore=GENERATED)
    build(copy, folder, "--wheel")
    build(copy, folder / "sdist")  # without a kind: the sdist, and the wheel out of it
    return folder


def wheel_files(folder: Path) -> set[str]:
    """The names in the wheel, its own metadata left out."""
    [wheel] = folder.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert len(names) == len(set(names)), "a file is in the wheel twice"
    return {name for name in names if ".dist-info/" not in name}


def test_wheel_holds_exactly_the_files_of_the_tree(built: Path) -> None:
    """Every module, recipe, table and stub is in the wheel once, at its place, and nothing else is."""
    assert wheel_files(built) == shipped_files()


def test_wheel_from_the_source_distribution_is_the_same(built: Path) -> None:
    """The source distribution is enough to build the same wheel."""
    assert wheel_files(built / "sdist") == wheel_files(built)


def test_a_wheel_without_kernels_is_for_every_machine(built: Path) -> None:
    """Its tag is that of pure Python, and it takes every numba that the source takes."""
    [wheel] = built.glob("*.whl")
    assert wheel.name.endswith("-py3-none-any.whl")
    assert not [need for need in requirements(wheel) if "==" in need.partition(";")[0]]


@pytest.mark.slow
def test_a_wheel_with_kernels_is_for_one_python_and_one_numba(tmp_path: Path) -> None:
    """Its tag names this Python and system, and its requirements the numba that its kernels are made by."""
    copy = tmp_path / "copy"
    shutil.copytree(ROOT, copy, symlinks=True, ignore=GENERATED)
    (copy / "filters/compilation/signatures.json").write_text("{}")  # nothing to compile, which takes a minute
    build(copy, tmp_path, "--wheel", kernels="")
    [wheel] = tmp_path.glob("*.whl")
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert f"-{python}-{python}-" in wheel.name
    assert {f"{name}=={version(name)}" for name in ("numba", "llvmlite")} <= set(requirements(wheel))


@pytest.mark.slow
def test_type_checkers_find_all_names_in_the_installed_package(built: Path, tmp_path: Path) -> None:
    """In the README's program, beside an installed wheel, pyright finds the planted errors and nothing else."""
    pytest.importorskip("pyright")
    venv.create(tmp_path / "venv")
    python = tmp_path / "venv/bin/python"
    [packages] = (tmp_path / "venv/lib").glob("python*/site-packages")
    [wheel] = built.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(packages)
    (packages / "others.pth").write_text(sysconfig.get_path("purelib"))  # numpy
    shutil.copytree(ROOT / "tests/typing", tmp_path / "checked/tests/typing")
    command = [sys.executable, "-m", "pyright", "--pythonpath", str(python)]
    done = subprocess.run(command, cwd=tmp_path / "checked/tests/typing", capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout


def test_source_distribution_holds_what_building_and_testing_need(built: Path) -> None:
    """Every file of the tree's own folders is in the source distribution, and the linked folders are in it once."""
    [archive] = (built / "sdist").glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        names = {str(PurePosixPath(*PurePosixPath(n).parts[1:])) for n in opened.getnames()}
    for folder in ("src/pymeshfair", "filters", "plugins", "mlx_scripts", "tests"):
        for path in (ROOT / folder).glob("**/*.py"):
            relative = path.relative_to(ROOT)
            linked = relative.parts[:2] == ("src", "pymeshfair") and relative.parts[2] in {"filters", "plugins", "mlx_scripts"}
            assert (str(PurePosixPath(relative)) in names) != linked, relative
    files = ["pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md", "docs/bibliography.bib"]
    files += [str(path.relative_to(ROOT)) for path in (ROOT / ".ci").iterdir()]
    assert not [f for f in files if f not in names]


def test_every_package_is_in_a_package_of_the_wheel(built: Path) -> None:
    """A folder with modules has an ``__init__.py``, so that nothing works from the tree alone."""
    files = shipped_files()
    folders = {str(PurePosixPath(f).parent) for f in files if f.endswith(".py")}
    assert not [f for f in folders if f"{f}/__init__.py" not in files]


@pytest.mark.parametrize("package", ["filters", "plugins"])
def test_import_from_the_checkout_is_refused(package: str) -> None:
    """A second copy of a package, found through the working directory, stops at once and names the right import."""
    done = subprocess.run([sys.executable, "-c", f"import {package}"], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert f"ImportError: import pymeshfair.{package}, not the checkout folder" in done.stderr
