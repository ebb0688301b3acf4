"""Why a batch cannot begin, or cannot go on."""

from __future__ import annotations

from ..errors import PymeshfairError


class BatchError(PymeshfairError):
    """The batch as a whole cannot be done; what its journal holds stays done."""
