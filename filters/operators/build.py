"""The operators by name."""

from typing import Literal, TypeAlias, get_args

from ..checks import FilterInputError, check_choice
from ..mesh import Floats, Ints
from .cotangent import cotangent_laplacian, laplace_beltrami
from .inverse_length import inverse_length_laplacian
from .laplacian import Laplacian
from .robust import robust_cloud_laplacian, robust_mesh_laplacian
from .scale_dependent import scale_dependent_laplacian
from .uniform import uniform_laplacian

OperatorName: TypeAlias = Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "laplace_beltrami", "robust"]
OPERATOR_NAMES: tuple[OperatorName, ...] = get_args(OperatorName)


def build_laplacian(vertices: Floats, faces: Ints, operator: OperatorName) -> Laplacian:
    """The operator of that name on a mesh, or for "robust" and no faces on a point cloud.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, or (0, 3) for a point cloud.
        operator: "uniform", "inverse_length" and "cotangent" are normalised: L has no unit and eigenvalues in [-2, 0].
            "scale_dependent", "laplace_beltrami" and "robust" have the unit of one over a squared length.

    Raises:
        FilterInputError: an unknown name, or a point cloud with another operator than "robust".
    """
    check_choice("operator", operator, OPERATOR_NAMES)
    if len(faces) == 0 and len(vertices) > 0:
        if operator != "robust":
            raise FilterInputError(f"operator {operator!r} needs triangles and there are none; for a point cloud take 'robust'")
        return robust_cloud_laplacian(vertices)
    if operator == "uniform":
        return uniform_laplacian(faces, len(vertices))
    if operator == "inverse_length":
        return inverse_length_laplacian(vertices, faces)
    if operator == "scale_dependent":
        return scale_dependent_laplacian(vertices, faces)
    if operator == "cotangent":
        return cotangent_laplacian(vertices, faces)
    if operator == "laplace_beltrami":
        return laplace_beltrami(vertices, faces)
    return robust_mesh_laplacian(vertices, faces)
