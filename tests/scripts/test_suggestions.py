"""Suggestions are right or absent: from the facts about older versions, else for a slip of spelling alone."""

from __future__ import annotations

import pytest

from pymeshfair.errors import nearest
from pymeshfair.scripts.read import SLIP
from tests.scripts.texts import one_filter, problems, script

DECIMATION = "Simplification: Quadric Edge Collapse Decimation"


@pytest.mark.parametrize(
    ("name", "suggestion", "message"),
    [
        ("Compact vertices", None, "leave it out"),
        ("Compact faces", None, "leave it out"),
        ("Remove Non Manifold Edges", "Repair non Manifold Edges", "it removes faces"),
        ("Merge Selected Layers", "Flatten Visible Layers", "merges the visible layers"),
        ("CSG Operation", None, "'Mesh Boolean: Union'"),
        ("Poisson Reconstruction", "Surface Reconstruction: Screened Poisson", "no MeshLab has had"),
        ("Change the current layer", None, "no filter of today changes the current layer"),
        ("Smooth: Laplacian", "Laplacian Smooth", "no MeshLab has had"),
        ("Consistent Vertex Order", None, "no MeshLab had it"),
        (
            "Surface Reconstruction: Poisson",
            "Surface Reconstruction: Screened Poisson",
            "the parameter pointWeight with the value 0",
        ),
        ("Make It Smooth", None, "there is no filter of that name"),
        ("Delete Selection", None, "there is no filter of that name"),
        ("Taubin Smoth", "Taubin Smooth", "there is no filter of that name"),
        ("apply_coord_taubin_smothing", "Taubin Smooth", "there is no filter of that name"),
    ],
)
def test_a_wrong_filter_leads_to_the_right_one_or_to_none(name: str, suggestion: str | None, message: str) -> None:
    """One message says what became of a filter; a name that is merely similar is not suggested."""
    (found,) = problems(one_filter(name, '<Param type="RichInt" name="x" value="1"/>'))
    assert found.suggestion == suggestion
    assert message in found.message


@pytest.mark.parametrize(
    ("filter_name", "parameter", "suggestion", "message"),
    [
        (DECIMATION, "BoundaryValue", None, "it has TargetFaceNum"),
        (DECIMATION, "PlanarSimp", None, "it has TargetFaceNum"),
        (DECIMATION, "targetfacenum", "TargetFaceNum", "it has"),
        (DECIMATION, "BondaryWeight", "BoundaryWeight", "it has"),
        ("Select Crease Edges", "AngleDeg", None, "it is replaced by AngleDegNeg and AngleDegPos now"),
        ("Transform: Rotate", "ToAll", "allLayers", "called 'allLayers' now"),
        ("Convex Hull", "reorient", None, "MeshLab has dropped it"),
        ("Surface Reconstruction: Screened Poisson", "SamplesPerNode", "samplesPerNode", "called 'samplesPerNode' now"),
    ],
)
def test_a_wrong_parameter_leads_to_the_right_one_or_to_none(
    filter_name: str, parameter: str, suggestion: str | None, message: str
) -> None:
    """What became of a parameter is said from the facts; one that is merely similar is not suggested."""
    (found,) = problems(one_filter(filter_name, f'<Param type="RichInt" name="{parameter}" value="1"/>'))
    assert found.suggestion == suggestion
    assert message in found.message


def test_an_xmlfilter_is_one_message() -> None:
    """However many parameters an <xmlfilter> has, one message says what it is."""
    params = [f'<xmlparam name="p{i}" value="1"/>' for i in range(10)]
    (found,) = problems(script('<xmlfilter name="Screened Poisson Surface Reconstruction">', *params, "</xmlfilter>"))
    assert "`pymeshfair upgrade` rewrites it" in found.message


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("boundary", "Boundary"),
        ("Boundray", "Boundary"),
        ("Bndary", None),
        ("mu", "mu"),
        ("nu", None),
        ("Boundaryy", "Boundary"),
    ],
)
def test_only_a_slip_is_forgiven(name: str, found: str | None) -> None:
    """In a name of eight letters one may be added, dropped or swapped; in one of two none."""
    assert nearest(name, ["Boundary", "mu"], cutoff=SLIP) == found
