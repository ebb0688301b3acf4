"""The operator of spectral filters, as a parameter."""

from pymeshfair.declaration import Enum
from pymeshfair.filters.spectral import SPECTRAL_OPERATORS

OPERATOR = Enum(
    label="Operator",
    choices=SPECTRAL_OPERATORS,
    advanced=True,
    help="'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same for slivers and non-manifold meshes; "
    "'auto' takes the robust one where it is needed.",
)
