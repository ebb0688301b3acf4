"""The work of a worker: reads the mesh, applies the steps, writes the result to the staging folder, and reports.

The only module of a run in which MeshLab is at work.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ..declaration import FilterClass
from ..errors import FilterInputError, Place, StepFailedError
from ..files.announced import Announced
from ..files.errors import InputError, OutputError
from ..files.formats import ATTRIBUTES
from ..files.inputs import inspect_input
from ..files.provenance import described_file, read_provenance
from ..files.reading import apply_matrix, load_mesh, unchanged
from ..files.saving import attributes_of, save_mesh
from ..filters.compilation import on_compilation
from ..meshset import MeshSet
from ..recipe import head_info
from ..scripts.script import Script
from ..scripts.traps import lengths_out_of_proportion
from .guarding import breaches
from .intervention import stage_map
from .job import Compiling, Event, Message, PhaseStarted, StepFinished, StepProgress, StepStarted
from .measuring import Found, Measuring, change_of
from .mesh_arrays import write_arrays
from .messages import Assignment, encode_event, mark
from .origins import displacement_of, find_origins, mark_origins
from .plain_values import plain
from .reasons import caused_by_memory, reason_of
from .shape_change import warnings_of
from .suitability import instead, traits_asked_for
from .survey import survey

#: the least change of progress that is reported
_SMALLEST_PROGRESS = 0.005


class Session:
    """One run in this process."""

    def __init__(self, assignment: Assignment, tell: Callable[[Mapping[str, Any]], None]) -> None:
        """See the class; `tell` sends a document to the supervisor."""
        self._assignment = assignment
        self._tell = tell
        self._meshes = MeshSet(verbose=True)  # MeshLab then tells its progress on stderr
        self._meshes.on_progress = self._progress
        self._meshes.on_note = self._note
        self._number, self._given, self._told = 0, 0, 0.0
        self._notes: list[str] = []
        self._warnings: list[str] = []
        self._measuring = Measuring(wanted=assignment.measures, followed=assignment.is_followed)

    def run(self) -> dict[str, Any]:
        """Carry the assignment out; the report for the supervisor.

        Raises:
            InputError, OutputError, StepFailedError, MemoryError: each as the class says.
        """
        on_compilation(lambda so_far: self._event(Compiling(**vars(so_far))))
        self._event(PhaseStarted("reading"))
        announced, source = self._load(self._assignment.input)
        self._given = self._meshes.current_mesh_id()
        source["others"] = [self._load(path)[1] for path in self._assignment.others]
        self._meshes.set_current_mesh(self._given)
        before = self._looked(InputError(self._assignment.input, "it has coordinates that are not finite"))
        for text in lengths_out_of_proportion(Script(self._assignment.steps), diagonal=before.diagonal):
            self._warn(text)
        present = attributes_of(self._meshes, announced)
        if self._assignment.output is None:
            if self._assignment.arrays is not None:
                write_arrays(self._meshes, present, self._assignment.arrays, intersections=self._assignment.self_intersections)
            attributes = [a for a in ATTRIBUTES if a in present]
            measured = {"before": before.described, "attributes": attributes, "warnings": self._warnings}
            return {"input": source, **measured, "survey": survey(self._assignment, before, present)}
        if taken := head_info(self._assignment.head).superseded:
            self._warn(f"{self._assignment.recipe} is superseded: {taken}")
        traits, unsuited = traits_asked_for(self._assignment, before, present)
        if unsuited:
            self._warn(unsuited)
        if self._assignment.is_followed:
            mark_origins(self._meshes.current_mesh())
        with self._meshes.deferred():
            steps = [self._step(number) for number in range(1, len(self._assignment.steps) + 1)]
        written = self._write(announced, before, present)
        return {"input": source, "steps": steps, "counted": announced.vertices is not None, "traits": plain(traits), **written}

    def _load(self, path: Path) -> tuple[Announced, dict[str, Any]]:
        """Check a file and load it as the current layer; what it declares, and which file it was."""
        told = self._assignment
        given = told.stage / f"given-{self._meshes.mesh_number()}"
        with unchanged(path):
            try:
                announced = inspect_input(path, given, allow_outside=told.allow_outside, unchecked=told.unchecked)
            except OutputError as error:  # without room for the copy that MeshLab is given, there is none for the output
                raise OutputError(told.output or error.path, error.reason) from error
            described = described_file(path) | {"side_files": [described_file(side) for side in announced.side_files]}
            self._lose(load_mesh(self._meshes, path, announced), InputError, path)
            announced = replace(announced, points=None)  # they have been compared
        for doubt in announced.doubts:
            self._warn(f"{path.name}: {doubt}")
        for file in set(given.glob("*")) - {texture.file for texture in announced.textures}:
            file.unlink()  # but textures that were within the input go to the output
        return announced, described

    # --------------------------------------------------------------------------------------------------------------- steps

    def _step(self, number: int) -> dict[str, Any]:
        step = self._assignment.steps[number - 1]
        self._number, self._told, self._notes = number, 0.0, []
        self._event(StepStarted(number, len(self._assignment.steps), step.filter.name))
        os.write(2, mark(number))
        started = time.perf_counter()
        try:
            parameters = self._meshes.effective_parameters(step, mesh_units=True)
            values = self._meshes.apply_step(step)
            if self._meshes.mesh_number() == 0:
                raise self._failed("it left no mesh")
            if number == len(self._assignment.steps):
                self._meshes.current_mesh()  # the result goes to MeshLab now, so that a refusal counts as this step's
        except (StepFailedError, MemoryError):
            raise
        except Exception as error:
            if caused_by_memory(error):
                raise MemoryError from error
            raise self._failed(reason_of(error, step)) from error
        seconds = time.perf_counter() - started
        os.write(2, mark(0))
        self._event(StepFinished(number, seconds))
        self._number = 0
        return {"parameters": plain(parameters), "values": plain(values), "seconds": seconds, "notes": self._notes}

    def _failed(self, reason: str) -> StepFailedError:
        """The failure of the current step, or of the last one when all are done."""
        steps = self._assignment.steps
        number = self._number or len(steps)
        filter = steps[number - 1].filter.name if steps else ""
        return StepFailedError(Place.of_step(number, len(steps), filter), reason)

    def _note(self, text: str) -> None:
        self._notes.append(text)
        self._event(Message(text, step=self._number))

    def _progress(self, fraction: float) -> None:
        if self._number and abs(fraction - self._told) >= _SMALLEST_PROGRESS:
            self._told = fraction
            self._event(StepProgress(self._number, min(max(fraction, 0.0), 1.0)))

    # ------------------------------------------------------------------------------------------------------------- writing

    def _write(self, announced: Announced, before: Found, present: set[str]) -> dict[str, Any]:
        output, stage = self._assignment.output, self._assignment.stage
        assert output is not None
        self._event(PhaseStarted("writing"))
        # The layer of which a step made another one is in its file.
        kept = self._meshes.current_mesh_id() != self._given and self._meshes.mesh_id_exists(self._given)
        if self._meshes.mesh_number() > 1 + kept:
            layer = self._meshes.current_mesh().label()
            text = f"the recipe ends with {self._meshes.mesh_number()} layers; only the current one, {layer!r}, is written"
            self._lose([text], OutputError, output)
        if apply_matrix(self._meshes):
            self._warn("the layer's matrix was applied to its coordinates, as files do not hold it")
        if self._meshes.current_mesh().vertex_number() == 0:
            raise self._failed("nothing is left of the mesh after the last step")
        if gone := [a for a in ATTRIBUTES if a in present - attributes_of(self._meshes, announced, present)]:
            self._lose([f"after the steps the mesh has no {' and no '.join(gone)} any more"], OutputError, output)
        after = self._looked(self._failed("the result has coordinates that are not finite"))
        said: dict[str, Any] = {"before": before.described, "after": after.described, "change": None, "warnings": self._warnings}
        if change := change_of(before, after):
            said["change"] = plain(asdict(change))
            for text in warnings_of(change, lambda: instead(self._assignment, before, present)):
                self._warn(text)
        if self._assignment.is_followed:
            said |= self._watched(before, after)
            if said.get("breaches") and not self._assignment.keep_broken:
                return said
        try:
            return {**said, **self._saved(announced, present, output, stage, after)}
        except OSError as error:
            raise OutputError(output, (error.strerror or str(error)).lower()) from error

    def _saved(self, announced: Announced, present: set[str], output: Path, stage: Path, after: Found) -> dict[str, Any]:
        """Write the files to the staging folder; what they are."""
        saved = save_mesh(
            self._meshes,
            announced,
            output,
            stage / "new",
            resolution=after.resolution,
            changed=bool(self._assignment.steps),
            began=present,
            textures_changed=any(FilterClass.TEXTURE in step.filter.classes for step in self._assignment.steps),
            record=read_provenance(output),
            own_texture_names=self._assignment.own_texture_names,
        )
        self._lose(saved.warnings, OutputError, output)
        files = [(f, described_file(f.staged, named=f.target)) for f in (saved.output, *saved.side_files)]
        described = [entry for _, entry in files] + [described_file(path) for path in saved.reused]
        return {
            "output": described[0] | {"side_files": described[1:]},
            "staged": [{"staged": str(f.staged), "target": str(f.target)} for f, _ in files],
        }

    def _watched(self, before: Found, after: Found) -> dict[str, Any]:
        """How far vertices have moved, the guards that were broken, and the staged files of the intervention map."""
        mesh, guards, target = self._meshes.current_mesh(), self._assignment.guards, self._assignment.map
        original, result = before.arrays, after.arrays
        assert original is not None
        assert result is not None
        origins = find_origins(mesh, original)
        said: dict[str, Any] = {"displacement": asdict(displacement_of(origins))} if self._assignment.displacement else {}
        if not self._assignment.is_watched:
            return said
        if not origins.known:
            self._warn("a step made a new mesh, so that its elements cannot be followed: distances are those from the input")
        found = breaches(guards, origins, original, *result, before.described, after.described)
        maps = [] if target is None else stage_map(self._assignment.stage / "new", target, *result, original, origins)
        return said | {"breaches": [plain(asdict(breach)) for breach in found], "maps": maps}

    def _looked(self, refusal: Exception) -> Found:
        """What is known of the current mesh."""
        try:
            return self._measuring.look(self._meshes.current_mesh())
        except FilterInputError as error:
            raise refusal from error

    def _event(self, event: Event) -> None:
        self._tell(encode_event(event))

    def _lose(self, texts: Sequence[str], refusal: type[InputError | OutputError], path: Path) -> None:
        """Warn of what is not kept, or refuse that."""
        if texts and self._assignment.keep_all:
            raise refusal(path, f"{'; '.join(texts)}. With --keep-all that is an error")
        for text in texts:
            self._warn(text)

    def _warn(self, text: str) -> None:
        self._warnings.append(text)
        self._event(Message(text, "warning"))
