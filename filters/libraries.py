"""Libraries that are imported at first use, since together they take half a second and no filter needs them all."""

import importlib
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any


class ImportedWhenUsed:
    """A module that is imported when one of its attributes is first used.

    Unlike `importlib.util.LazyLoader`, it is safe in several threads also before Python 3.12, and it imports submodules.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        """Returns the attribute of the module, or its submodule of this name."""
        if attribute.startswith("__"):
            raise AttributeError(attribute)  # tools that inspect objects must not cause the import
        module = importlib.import_module(self._name)
        try:
            value = getattr(module, attribute)
        except AttributeError:
            value = importlib.import_module(f"{self._name}.{attribute}")
        setattr(self, attribute, value)
        return value


if TYPE_CHECKING:
    import robust_laplacian
    import threadpoolctl
    from scipy import fft, linalg, optimize, sparse, spatial, special
    from scipy.linalg import blas
else:
    for _name in ("fft", "linalg", "linalg.blas", "optimize", "sparse", "spatial", "special"):
        globals()[_name.rpartition(".")[2]] = ImportedWhenUsed(f"scipy.{_name}")
    robust_laplacian = ImportedWhenUsed("robust_laplacian")
    threadpoolctl = ImportedWhenUsed("threadpoolctl")


_lock = threading.Lock()
_limits: list[Any] = []  # the one limit of the process, repeated for each open context


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Context in which matrix products use one thread, since their bits depend on the number of threads."""
    blas.dgemm  # noqa: B018 - loads scipy's library now; the limit does not affect libraries loaded later
    with _lock, _in_control():
        _limits.append(_limits[0] if _limits else threadpoolctl.threadpool_limits(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _lock, _in_control():
            limit = _limits.pop()
            if not _limits:
                limit.restore_original_limits()


@contextmanager
def _in_control() -> Iterator[None]:
    """Context in which this thread may set limits: threadpoolctl 3.8 takes them only from the first thread that sets one."""
    release = getattr(threadpoolctl.OpenBLASController, "clear_controlling_thread", lambda force: None)
    release(force=True)
    yield
    release(force=True)


__all__ = ["ImportedWhenUsed", "one_blas_thread", "robust_laplacian", "threadpoolctl"]
__all__ += ["blas", "fft", "linalg", "optimize", "sparse", "spatial", "special"]
