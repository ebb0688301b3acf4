"""The compiled functions of a package."""

import sys
from collections.abc import Iterator

from pymeshfair.filters.compilation import kernel


def loaded_kernels(package: str) -> Iterator[tuple[str, str, kernel.Kernel]]:
    """Yields the module name, the name and the kernel of every kernel in the loaded modules of a package."""
    for module_name, module in list(sys.modules.items()):
        if module_name.startswith(f"{package}."):
            for name, value in list(vars(module).items()):
                if isinstance(value, kernel.Kernel) and value.__module__ == module_name:
                    yield module_name, name, value
