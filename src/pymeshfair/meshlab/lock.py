"""One thread at a time within MeshLab: its filters, readers and writers share state of the process, and crash side by side."""

from __future__ import annotations

import threading

#: held around every call of MeshLab that does more than hand out an array
MESHLAB = threading.RLock()
