"""Reads and formats ``OUTPUT.provenance.json``, the record of a run; in equal runs only ``"run"`` and messages can differ."""

import hashlib
import json
from collections.abc import Mapping
from itertools import chain
from pathlib import Path
from typing import Any

SCHEMA = "pymeshfair-provenance-1"  # the name of the format; the number grows when the meaning of a field changes


def provenance_path(output: Path) -> Path:
    """Returns the path of the record of `output`: ``scan.ply.provenance.json`` beside ``scan.ply``."""
    return output.parent / f"{output.name}.provenance.json"


def read_provenance(output: Path) -> dict[str, Any] | None:
    """Returns the record beside `output`, or None if there is no valid one."""
    try:
        record = json.loads(provenance_path(output).read_bytes())
        parts = [record["input"], record["output"]]
        lists = [parts[0].get("others", ()), parts[1].get("side_files", ()), record.get("guards", {}).get("maps", ())]
        parts += [*(record.get(name, {}) for name in ("recipe", "options", "guards", "versions", "run")), *chain(*lists)]
        unit = record.get("options", {}).get("unit", "")
    except (AttributeError, KeyError, OSError, RecursionError, TypeError, ValueError):
        return None
    known = record.get("schema") == SCHEMA and isinstance(unit, str)
    return record if known and all(isinstance(part, dict) for part in parts) else None


def recorded_digest(record: Mapping[str, Any] | None, path: Path) -> str | None:
    """Returns a record's SHA-256 of the output, side file or map (``run --map``) with the name of `path`; None if missing."""
    if record is None:
        return None
    files = [record["output"], *(record["output"].get("side_files") or ()), *(record.get("guards", {}).get("maps") or ())]
    named = (f for f in files if isinstance(f, dict) and Path(str(f.get("path"))).name == path.name)
    return next((str(f["sha256"]) for f in named if f.get("sha256")), None)


def sha256_of(path: Path) -> str:
    """Returns the digest in hexadecimal."""
    digest = hashlib.sha256()
    with path.open("rb", buffering=0) as file:
        while chunk := file.read(1 << 20):
            digest.update(chunk)
    return digest.hexdigest()


def described_file(path: Path, *, named: Path | None = None) -> dict[str, Any]:
    """Returns path, size and digest of a file for a record; `named` is its later path if the file will be moved."""
    return {"path": str((named or path).absolute()), "bytes": path.stat().st_size, "sha256": sha256_of(path)}


def formatted(record: Mapping[str, Any]) -> bytes:
    """Returns the record as the bytes of its file."""
    return (json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8", "surrogateescape")
