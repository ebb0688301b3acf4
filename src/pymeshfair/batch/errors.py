"""Why a batch cannot begin, or cannot go on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..errors import PymeshfairError


class BatchError(PymeshfairError):
    """The batch as a whole cannot be done; what its journal holds stays done."""


class UnfitWorkersError(BatchError):
    """Some workers would not give the results that this machine gives, or do not see its files; nothing was begun.

    Attributes:
        reasons: by the address of a worker, what is wrong with it.
    """

    def __init__(self, reasons: Mapping[str, Sequence[str]], fit: int) -> None:
        told = "\n".join(f"  {address}: {'; '.join(found)}" for address, found in reasons.items())
        super().__init__(
            f"{len(reasons)} of {len(reasons) + fit} workers cannot take part, and nothing was begun:\n{told}\n"
            "mend or stop them, and start the batch again"
        )
        self.reasons = dict(reasons)


class LostSchedulerError(BatchError):
    """The scheduler does not answer any more."""

    def __init__(self) -> None:
        super().__init__("the scheduler does not answer any more; --resume goes on with what is not done, when it runs again")
