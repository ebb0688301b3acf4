"""The packages of the wheel: every folder that has an ``__init__.py``, in the folders that ``pymeshfair`` is made of."""

from setuptools import find_packages, setup

#: the folder of each; src/pymeshfair has links to the others, which a source distribution has not
FOLDERS = {
    "pymeshfair": "src/pymeshfair",
    "pymeshfair.filters": "filters",
    "pymeshfair.plugins": "plugins",
    "pymeshfair.mlx_scripts": "mlx_scripts",
}
LINKS = [pattern for name in ("filters", "plugins", "mlx_scripts") for pattern in (name, f"{name}.*")]

packages = []
for name, folder in FOLDERS.items():
    packages += [name, *(f"{name}.{inside}" for inside in find_packages(folder, exclude=LINKS if name == "pymeshfair" else ()))]
setup(packages=packages, package_dir=FOLDERS)
