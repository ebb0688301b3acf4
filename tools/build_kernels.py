"""Compiles the kernels when a wheel is built, as ``pip install`` does, so that no first run has to wait for that.

They go into the wheel beside the modules, and serve where Python, numba and the level of the processor are those of the build;
elsewhere each is compiled when it is first used. PYMESHFAIR_KERNELS names other levels than that of this machine, such as
"x86-64-v3 x86-64-v2"; "none" leaves the kernels out.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from setuptools.command.build_py import build_py

#: seconds; more than the slowest machine takes
_PATIENCE = 1800
#: compiles the listed kernels into the store
_PROGRAM = (
    "import sys; from pymeshfair.filters.compilation import compile_ahead, listed_signatures;"
    "sys.exit('\\n'.join(compile_ahead(listed_signatures())) or None)"
)


class BuildWithKernels(build_py):  # type: ignore[misc]
    """Copies the packages, then compiles what is in them."""

    def run(self) -> None:
        """See the class; a build without kernels is no failure."""
        super().run()
        if self.editable_mode:
            return
        names = os.environ.get("PYMESHFAIR_KERNELS", "")
        packages = Path(self.build_lib).absolute()
        kernels = packages / "pymeshfair/filters/compilation/kernels"
        shutil.rmtree(kernels, ignore_errors=True)  # of a build before
        if names == "none":
            return
        with tempfile.TemporaryDirectory() as folder:
            path = os.pathsep.join([str(packages), *filter(None, [os.environ.get("PYTHONPATH")])])
            environment = {**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": folder, "PYTHONDONTWRITEBYTECODE": "1"}
            command = [sys.executable, "-c", _PROGRAM]
            levels = [{"NUMBA_CPU_NAME": level} for level in names.split()] or [{}]
            try:
                for level in levels:
                    subprocess.run(command, cwd=folder, env=environment | level, timeout=_PATIENCE, check=True)
            except (OSError, subprocess.SubprocessError) as error:
                self.warn(f"not all kernels could be compiled now; what is missing is compiled at the first run: {error}")
            made = Path(folder) / "pymeshfair"
            if made.is_dir():
                shutil.copytree(made, kernels)
