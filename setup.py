"""What pyproject.toml cannot say: the packages of the wheel, and what depends on the kernels that are compiled into it.

A wheel with kernels is for one Python, one system and the numba that compiled them, and says so by its tag and its requirements.
PYMESHFAIR_KERNELS=none builds one without, for any machine (`tools/build_kernels.py`).
"""

import os
import sys
from importlib.metadata import version

from setuptools import Distribution, find_packages, setup

#: the folder of each; src/pymeshfair has links to the others, which a source distribution has not
FOLDERS = {
    "pymeshfair": "src/pymeshfair",
    "pymeshfair.filters": "filters",
    "pymeshfair.plugins": "plugins",
    "pymeshfair.mlx_scripts": "mlx_scripts",
}
LINKS = [pattern for name in ("filters", "plugins", "mlx_scripts") for pattern in (name, f"{name}.*")]
DEPENDENCIES = [
    "pymeshlab>=2025.7",
    "numpy>=2.0",
    "scipy>=1.13",
    "numba>=0.61",
    "robust-laplacian>=1.0",
    "pillow>=11",
    "threadpoolctl>=3.5",
    "fast-simplification>=0.1.9",
    "jinja2>=3.1",
    "typer>=0.20,<0.26",  # 0.26 and newer import pydantic: 0.2 s of every command
    "click>=8.2,<8.5",  # with 8.5 and newer such versions of typer do not show what arguments mean
    "rich>=13",
]
HAS_KERNELS = os.environ.get("PYMESHFAIR_KERNELS") != "none"


class DistributionWithKernels(Distribution):
    """Has machine code, so that its wheel gets the tag of this Python and this system."""

    def has_ext_modules(self) -> bool:
        """Whether there is machine code."""
        return HAS_KERNELS


if HAS_KERNELS and "sdist" not in sys.argv:  # code of another numba would not be used, and compiled anew at the first run
    DEPENDENCIES += [f"{name}=={version(name)}" for name in ("numba", "llvmlite")]

packages = []
for name, folder in FOLDERS.items():
    packages += [name, *(f"{name}.{inside}" for inside in find_packages(folder, exclude=LINKS if name == "pymeshfair" else ()))]
setup(packages=packages, package_dir=FOLDERS, install_requires=DEPENDENCIES, distclass=DistributionWithKernels)
