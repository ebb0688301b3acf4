"""Pymeshlab's own class of mesh sets, and the lock under which threads call it.

Imported with `pymeshfair.MeshSet`, since a program may put that in the place of pymeshlab's afterwards.
"""

from __future__ import annotations

import threading
from typing import Any

import pymeshlab

BASE: Any = pymeshlab.MeshSet
#: MeshLab's filters, readers and writers share state of the process: one thread at a time may be within them
MESHLAB = threading.RLock()
