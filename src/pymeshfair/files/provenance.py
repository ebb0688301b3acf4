"""``OUTPUT.provenance.json``: how an output came about; the same bytes for the same run, except under ``"run"``."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: the name of the format in a provenance file; the number grows when the meaning of a field changes
SCHEMA = "pymeshfair-provenance-1"


def provenance_path(output: Path) -> Path:
    """The file that says how `output` came about: ``scan.ply.provenance.json`` beside ``scan.ply``."""
    return output.with_name(f"{output.name}.provenance.json")


def read_provenance(output: Path) -> dict[str, Any] | None:
    """The record in the file beside `output`, or None if there is none of ours."""
    try:
        record = json.loads(provenance_path(output).read_bytes())
    except (OSError, ValueError):
        return None
    if not isinstance(record, dict) or record.get("schema") != SCHEMA:
        return None
    return record if all(isinstance(record.get(part), dict) for part in ("input", "output")) else None


def recorded_digest(record: Mapping[str, Any] | None, path: Path) -> str | None:
    """The SHA-256 digest that a record gives for the output or a side file of it, by the file's name; None if it gives none."""
    if record is None:
        return None
    files = [record["output"], *record["output"].get("side_files", ()), *record.get("guards", {}).get("maps", ())]
    files = [f for f in files if isinstance(f, dict)]
    return next((str(f.get("sha256")) for f in files if Path(str(f.get("path"))).name == path.name), None)


def sha256_of(path: Path) -> str:
    """The SHA-256 digest of a file in hexadecimal."""
    digest = hashlib.sha256()
    with path.open("rb", buffering=0) as file:
        while chunk := file.read(1 << 20):
            digest.update(chunk)
    return digest.hexdigest()


def described_file(path: Path, *, named: Path | None = None) -> dict[str, Any]:
    """The path, size and digest of a file, for a record; `named` is the path to write down if the file will be moved there."""
    return {"path": str((named or path).absolute()), "bytes": path.stat().st_size, "sha256": sha256_of(path)}


def formatted(record: Mapping[str, Any]) -> bytes:
    """The record as the bytes of its file."""
    return (json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8", "surrogateescape")
