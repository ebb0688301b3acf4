"""The registry: MeshLab's filters and plugins of installed packages under both of their names."""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import pymeshfair
from pymeshfair import registry
from pymeshfair.commands.doctor import look_at_plugins
from pymeshfair.errors import UnknownNameError
from tests.commands.command_line import invoke

Install = Callable[..., None]

GOOD = """
    from pymeshfair.declaration import Edit, FilterClass, Layer, mesh_filter

    @mesh_filter(name="Scan Lab Nothing", classes=FilterClass.OTHER)
    def apply_coord_scan_lab_nothing(layer: Layer) -> Edit:
        "Does nothing."
        return Edit()

    the_same_again = apply_coord_scan_lab_nothing
"""
OTHER_NAME = GOOD.replace("def apply_coord_scan_lab_nothing", "def apply_coord_taubin_smoothing").partition("\n    the_same")[0]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Installs packages of one module each into a folder on sys.path, as pip would leave them: the module and its dist-info."""
    monkeypatch.syspath_prepend(tmp_path)

    def install(name: str, source: str, entry_points: str, *, metadata: str | None = None) -> None:
        (tmp_path / f"{name}_filters.py").write_text(textwrap.dedent(source))
        info = tmp_path / f"{name}-1.0.dist-info"
        info.mkdir()
        if metadata is None:
            metadata = f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n"
        (info / "METADATA").write_text(metadata)
        (info / "entry_points.txt").write_text(f"[{registry.ENTRY_POINT_GROUP}]\n{entry_points}\n")
        modules.append(f"{name}_filters")
        registry.reload_plugins()

    modules: list[str] = []
    yield install
    monkeypatch.undo()
    for module in modules:
        sys.modules.pop(module, None)
    registry.reload_plugins()


def _reasons(distribution: str) -> list[str]:
    return [b.reason for b in registry.broken_plugins() if b.distribution == distribution]


def test_our_own_plugins_are_whole() -> None:
    """Every plugin of pymeshfair loads, and each of its filters is known under its Python name and its GUI name."""
    assert not [b for b in registry.broken_plugins() if b.distribution == "pymeshfair"]
    ours = [f for f in registry.custom_filters() if f.origin == "pymeshfair"]
    assert {"apply_coord_taubin_fairing", "apply_coord_implicit_fairing"} <= {f.python_name for f in ours}
    for known in ours:
        assert registry.find_filter(known.name) is registry.find_filter(known.python_name) is known


def test_an_installed_package_adds_filters(install: Install) -> None:
    """A filter that an installed package names by entry point is found by both names and knows its package."""
    install("scanlab", GOOD, "lab = scanlab_filters")
    found = registry.find_filter("Scan Lab Nothing")
    assert found is registry.find_filter("apply_coord_scan_lab_nothing")
    assert found.origin == "scanlab"
    assert found in registry.all_filters()
    assert _reasons("scanlab") == []  # one filter under two names in its module is one filter


def test_an_entry_point_may_name_one_filter(install: Install) -> None:
    """An entry point of the form ``module:name`` adds that filter alone."""
    install("scanlab", GOOD, "lab = scanlab_filters:the_same_again")
    assert registry.find_filter("Scan Lab Nothing").origin == "scanlab"


@pytest.mark.parametrize(
    ("source", "entry_points", "reason"),
    [
        ("import no_such_package", "lab = broken_filters", "ModuleNotFoundError: No module named 'no_such_package'"),
        ("raise SystemExit(3)", "lab = broken_filters", "SystemExit: 3"),
        ("def f(:", "lab = broken_filters", "SyntaxError"),
        ("", "lab = broken_filters", "declares no filter"),
        ("x = 3", "lab = broken_filters:x", "TypeError"),
        ("", "lab = broken_filters:missing", "AttributeError"),
        ("", "lab = not a module", ""),
        (
            "from pymeshfair.declaration import Filter\nf = Filter(python_name='apply_coord_hollow', name='Hollow')",
            "lab = broken_filters",
            "has no function",
        ),
        (OTHER_NAME, "lab = broken_filters", "'apply_coord_taubin_smoothing' is taken"),
        (
            GOOD.replace("Scan Lab Nothing", "Taubin Smooth"),
            "lab = broken_filters",
            "'Taubin Smooth' is taken by 'apply_coord_taubin_smoothing' of MeshLab",
        ),
        (GOOD.replace("Scan Lab Nothing", " "), "lab = broken_filters", "needs a Python name and a menu name"),
        (GOOD.replace('"Does nothing."', ""), "lab = broken_filters", "DeclarationError: .* has no docstring"),
    ],
)
def test_a_broken_plugin_is_reported_and_stops_nothing(install: Install, source: str, entry_points: str, reason: str) -> None:
    """Whatever is wrong with a plugin, it is reported with its package; every other filter stays, the next plugin's included."""
    install("broken", source, entry_points)
    install("zealous", GOOD.replace("Scan Lab", "Zeal").replace("scan_lab", "zeal"), "lab = zealous_filters")
    broken = [b for b in registry.broken_plugins() if b.distribution == "broken"]
    assert len(broken) == 1
    assert broken[0].entry_point == entry_points
    assert re.search(reason, broken[0].reason)
    assert registry.find_filter("Taubin Smooth").origin == "MeshLab"
    assert registry.find_filter("Zeal Nothing").origin == "zealous"


def test_a_filter_of_a_plugin_that_fails_is_not_there_for_a_reason_that_is_told(install: Install, tmp_path: Path) -> None:
    """Wherever a filter of a plugin that cannot be imported is asked for, the plugin and its error are named."""
    install("broken", GOOD + "\n    import no_such_package\n", "lab = broken_filters")
    cause = "plugin 'lab' of broken cannot be used: ModuleNotFoundError: No module named 'no_such_package'"
    for name in ("apply_coord_scan_lab_nothing", "Scan Lab Nothing"):
        with pytest.raises(UnknownNameError) as caught:
            registry.find_filter(name)
        assert str(caught.value).startswith(f"there is no filter {name!r}; ")
        assert str(caught.value).endswith(f"({cause})")
        assert caught.value.cause == cause
    with pytest.raises(AttributeError, match=f"no attribute 'apply_coord_scan_lab_nothing'; {re.escape(cause)}$"):
        pymeshfair.MeshSet().apply_coord_scan_lab_nothing()  # type: ignore[attr-defined]
    script = tmp_path / "nothing.mlx"
    script.write_text('<FilterScript>\n<filter name="Scan Lab Nothing"/>\n</FilterScript>\n')
    assert f":2: filter 'Scan Lab Nothing': there is no filter of that name: {cause}\n" in invoke("check", script).stdout
    asked = invoke("info", "apply_coord_scan_lab_nothing")
    assert (asked.exit_code, asked.stderr.strip().endswith(f"no file; {cause}")) == (2, True)
    assert f"warning: {cause}" in invoke("list", "filters", "taubin").stderr


def test_a_plugin_without_memory_is_not_broken(install: Install) -> None:
    """If memory runs out while a plugin is loaded, the error is that, and not that there is no such filter."""
    install("scanlab", "raise MemoryError", "scanlab = scanlab_filters")
    with pytest.raises(MemoryError):
        registry.find_filter("apply_coord_scan_lab_nothing")


def test_an_unknown_name_tells_of_plugins_that_may_have_it(install: Install) -> None:
    """An unknown name gets its suggestion, and a plugin that failed is named all the same."""
    install("broken", "import no_such_package", "lab = broken_filters")
    with pytest.raises(UnknownNameError, match=r"did you mean 'Taubin Smooth'\? \(plugin 'lab' of broken cannot be used"):
        registry.find_filter("Taubin Smoothh")


@pytest.mark.parametrize("lost", ["apply_coord_scan_lab_nothing", "Scan Lab Nothing"])
def test_a_refused_filter_is_known_by_its_other_name(install: Install, lost: str) -> None:
    """A filter one of whose two names is taken is asked for by the other: the error says who took which name."""
    install("first", GOOD, "lab = first_filters")
    other = {"apply_coord_scan_lab_nothing": "apply_coord_other", "Scan Lab Nothing": "Other"}[lost]
    install("second", GOOD.replace(lost, other).partition("\n    the_same")[0], "lab = second_filters")
    with pytest.raises(UnknownNameError, match="taken by 'apply_coord_scan_lab_nothing' of first"):
        registry.find_filter(other)


def test_a_taken_name_is_that_of_the_first(install: Install) -> None:
    """Asking for a name that two packages declare gives the filter of the first; the doctor tells of the other."""
    install("first", GOOD, "lab = first_filters")
    install("second", GOOD, "lab = second_filters")
    assert registry.find_filter("Scan Lab Nothing").origin == "first"
    (finding,) = [f for f in look_at_plugins() if not f.ok]
    assert "taken by 'apply_coord_scan_lab_nothing' of first" in finding.detail


def test_packages_with_broken_metadata_are_reported(install: Install, tmp_path: Path) -> None:
    """A package whose entry points are no entry points, or that has no name, is known by its place and stops nothing."""
    install("mangled", "", "this line has no equals sign")
    install("nameless", GOOD, "lab = nameless_filters", metadata="")
    (tmp_path / "mangled-1.0.dist-info" / "METADATA").write_text("Name: mangled\n")
    registry.reload_plugins()
    assert any("mangled" in b.distribution for b in registry.broken_plugins())
    assert registry.find_filter("Scan Lab Nothing").origin.endswith("nameless-1.0.dist-info")
    assert registry.find_filter("apply_coord_taubin_smoothing").name == "Taubin Smooth"


def test_no_package_can_take_a_name_of_ours(install: Install) -> None:
    """A package whose name sorts before ours declares a filter under our name: ours stays, theirs is reported."""
    install("aaa", GOOD.replace("apply_coord_scan_lab_nothing", "apply_coord_taubin_fairing"), "lab = aaa_filters")
    assert registry.find_filter("apply_coord_taubin_fairing").origin == "pymeshfair"
    assert "is taken by 'apply_coord_taubin_fairing' of pymeshfair" in _reasons("aaa")[0]


def test_a_filter_imported_from_another_plugin_is_not_a_second_one(install: Install) -> None:
    """A plugin that imports a filter of ours to build on it neither breaks nor takes it over."""
    source = GOOD + "\n    from pymeshfair.plugins.smoothing import apply_coord_taubin_fairing\n"
    install("scanlab", source, "lab = scanlab_filters")
    assert _reasons("scanlab") == []
    assert registry.find_filter("apply_coord_taubin_fairing").origin == "pymeshfair"


def test_the_same_package_twice_on_the_path_counts_once(install: Install, tmp_path: Path) -> None:
    """A second copy of a package's metadata further down sys.path, as left by an editable install, is passed over."""
    install("scanlab", GOOD, "lab = scanlab_filters")
    (tmp_path / "scanlab.egg-info").mkdir()
    (tmp_path / "scanlab.egg-info" / "PKG-INFO").write_text("Name: scanlab\n")
    (tmp_path / "scanlab.egg-info" / "entry_points.txt").write_text("[pymeshfair.plugins]\nlab = scanlab_filters\n")
    registry.reload_plugins()
    assert len([f for f in registry.custom_filters() if f.origin == "scanlab"]) == 1
    assert _reasons("scanlab") == []


@pytest.mark.parametrize(
    ("wrong", "suggestion"),
    [
        ("apply_coord_taubin_smothing", "apply_coord_taubin_smoothing"),
        ("taubin smooth", "Taubin Smooth"),
        ("Dilate selection", "Dilate Selection"),
        ("meshing_remove_duplicated_vertices", "meshing_remove_duplicate_vertices"),
    ],
)
def test_an_unknown_name_gets_the_nearest(wrong: str, suggestion: str) -> None:
    """A Python name or a GUI name."""
    with pytest.raises(UnknownNameError, match=f"there is no filter '{wrong}'; did you mean '{suggestion}'") as caught:
        registry.find_filter(wrong)
    assert caught.value.suggestion == suggestion


def test_a_name_like_no_other_points_to_the_list() -> None:
    """Where nothing is near, the error says how to list the filters."""
    with pytest.raises(UnknownNameError, match="pymeshfair list filters"):
        registry.find_filter("0")


def test_all_filters_are_sorted_and_unique() -> None:
    """The list of all filters has MeshLab's 281 and ours, by Python name, each once."""
    names = [f.python_name for f in registry.all_filters()]
    assert names == sorted(set(names))
    assert sum(f.is_builtin for f in registry.all_filters()) == 281


def test_a_python_without_docstrings_is_refused_in_one_sentence() -> None:
    """A filter is described by its docstring, which -OO removes; before, seven plugins were to be installed anew."""
    program = "import pymeshfair; pymeshfair.filter_list()"
    done = subprocess.run([sys.executable, "-OO", "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stderr.endswith("which -OO or PYTHONOPTIMIZE=2 removes; start Python without it\n")
