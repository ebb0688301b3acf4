"""What the work of a run came to, on its way from the processes that did it to the files in their places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..files.writing import StagedFile


@dataclass(frozen=True)
class StepDone:
    """What a step did.

    Attributes:
        parameters: every parameter with its value on this mesh, in terms of JSON.
        values: what the filter reported, in terms of JSON.
        seconds: how long it took.
        messages: what it said.
    """

    parameters: Mapping[str, Any]
    values: Mapping[str, Any]
    seconds: float
    messages: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Report:
    """What the work of a run came to. Everything that is a mapping is in terms of JSON, as the provenance document has it.

    Attributes:
        input: which files were read.
        output: which file was written, with its side files; None if a limit was broken and nothing was written.
        steps: one for each step.
        staged: the output and its side files in the staging folder.
        before: the measures of the mesh as read; None if none are wanted. So the next two.
        after: those of the mesh as written.
        change: what lies between them.
        traits: what the recipe asked of the scan.
        warnings: what the user should know.
        breaches: the limits that were broken.
        maps: the files of the intervention map in the staging folder.
        tiles: how the work was cut; None if it was done in one piece.
        peak_memory: bytes that it took at most; None where that cannot be told.
    """

    input: Mapping[str, Any]
    output: Mapping[str, Any] | None = None
    steps: tuple[StepDone, ...]
    staged: tuple[StagedFile, ...] = ()
    before: Mapping[str, Any] | None = None
    after: Mapping[str, Any] | None = None
    change: Mapping[str, Any] | None = None
    traits: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    breaches: tuple[Mapping[str, Any], ...] = ()
    maps: tuple[StagedFile, ...] = ()
    tiles: Mapping[str, Any] | None = None
    peak_memory: int | None = None
