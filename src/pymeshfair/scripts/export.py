"""Writes a script that needs nothing but MeshLab: its own filters, every parameter, lengths in mesh units."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from ..declaration import FilterClass, Length
from ..registry import find_filter
from .guards import NO_GUARDS
from .problems import Problem, ScriptError
from .script import Script, Step
from .write import NOMINAL_DIAGONAL, NOMINAL_EDGE, format_script


@dataclass(frozen=True)
class MeshFacts:
    """The sizes of the mesh that a script is exported for."""

    diagonal: float  # of its bounding box
    mean_edge: float  # the mean length of its edges; of a point cloud, the mean distance to the nearest neighbour
    closed: bool  # whether every edge has two faces


def export_script(
    script: Script, *, mesh: MeshFacts | None = None, lengths: Sequence[Mapping[str, Length]] = ()
) -> tuple[str, tuple[str, ...]]:
    """The script for MeshLab's desktop and plain pymeshlab.

    A filter of a plugin is replaced where it declares that one of MeshLab's does the same. Settings, tags, limits and the
    unit, which mean nothing there, are left out.

    Args:
        script: the steps.
        mesh: the mesh that the script is for. Without it relative lengths cannot be mesh units, and a script that has any is
            refused, as is one with a filter that has an equal on closed meshes alone.
        lengths: by step, lengths in mesh units by Python parameter name, in place of relative ones; what is not there is
            relative to `mesh`.

    Raises:
        ScriptError: MeshLab alone cannot do what a step does, or a length is relative and no mesh is given; lists all of them.
        PymeshfairError: a text holds what XML cannot.
    """
    whole = script.with_defaults()
    closed, steps, replaced = mesh is not None and mesh.closed, list[Step](), list[str]()
    problems: list[Problem] = []
    for number, step in enumerate(whole.steps, 1):
        plain = step if step.filter.is_builtin else _equivalent(step, closed=closed)
        if plain is None:
            problems.append(_problem(script, step, why=_why_not(step, known=mesh is not None)))
            continue
        problems += _relative_lengths(script, plain) if mesh is None else ()
        if plain is not step:
            replaced.append(f"step {number}, {step.filter.name!r}, is MeshLab's {plain.filter.name!r}, which does the same")
        if plain is step and number <= len(lengths):
            plain = plain.with_checked(lengths[number - 1])
        steps.append(plain if mesh is None else plain.in_mesh_units(diagonal=mesh.diagonal, mean_edge=mesh.mean_edge))
        closed = closed and FilterClass.SMOOTHING in step.filter.classes  # any other step may open the mesh, or select
    if problems:
        raise ScriptError(problems)
    bare = (replace(step, tag="", settings={}) for step in steps)
    size = MeshFacts(NOMINAL_DIAGONAL, NOMINAL_EDGE, closed=False) if mesh is None else mesh
    plain_script = replace(whole.with_steps(bare), guards=NO_GUARDS, unit="")
    return format_script(plain_script, diagonal=size.diagonal, mean_edge=size.mean_edge), tuple(replaced)


def _equivalent(step: Step, *, closed: bool) -> Step | None:
    """The step with MeshLab's filter that does the same; None if there is none."""
    found = None if step.filter.equivalent is None else step.filter.equivalent(step.values)
    if found is None or (found.closed_only and not closed):
        return None
    own = find_filter(found.filter)
    return Step(own, own.with_defaults(found.values), step.line)


def _why_not(step: Step, *, known: bool) -> str:
    message = f"is a filter of {step.filter.origin}, which MeshLab lacks; MeshLab alone cannot run this step"
    found = None if step.filter.equivalent is None else step.filter.equivalent(step.values)
    if found is None:
        return message
    name = find_filter(found.filter).name
    return f"{message}: {name!r} does the same on closed meshes alone, " + (
        "and this one is open, or a step before may open it or select" if known else "say with --for MESH which mesh it is for"
    )


def _relative_lengths(script: Script, step: Step) -> Iterator[Problem]:
    for name, length in step.relative_lengths.items():
        why = f"is {length}, which depends on the size of the mesh; say with --for MESH which mesh the script is for"
        yield _problem(script, step, parameter=step.filter.parameter(name).xml_name, why=why)


def _problem(script: Script, step: Step, *, why: str, parameter: str | None = None) -> Problem:
    name = "recipe" if script.path is None else str(script.path)
    return Problem(file=name, line=step.line, filter=step.filter.name, parameter=parameter, message=why)
