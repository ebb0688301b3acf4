"""Results of filters, remembered while the same mesh is chosen for again and again with one step of the method left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from hashlib import blake2b
from typing import Any

import numpy as np
from denoising_metrics import Floats, Ints

from pymeshfair.filters.denoising import Setting, SettingsTried, automatic


class Family:
    """The results of a family of settings, each found when it is first read."""

    def __init__(self, results: Iterator[Floats]) -> None:
        """Of results still to come."""
        self._coming, self._results = results, list[Floats]()

    def __iter__(self) -> Iterator[Floats]:
        """From the first on."""
        at = 0
        while at < len(self._results) or self._more():
            yield self._results[at]
            at += 1

    def _more(self) -> bool:
        result = next(self._coming, None)
        if result is not None:
            self._results.append(result)
        return result is not None


def key_of(*values: object) -> bytes:
    """The same for equal arrays and texts."""
    digest = blake2b()
    for value in values:
        digest.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
    return digest.digest()


@contextmanager
def remembering() -> Iterator[None]:
    """`automatic_choice` runs no setting twice on the same points."""
    families: dict[bytes, list[Family]] = {}
    applied: dict[bytes, Floats] = {}
    apply: Callable[..., Floats] = Setting.apply

    class Remembered(SettingsTried):
        def __init__(self, faces: Ints, normals: Floats, direction: Any, **others: Any) -> None:
            super().__init__(faces, normals, direction, **others)
            self._key = key_of(faces, normals, direction, *others.values())

        def __call__(self, points: Floats, held: Ints) -> Sequence[Iterator[Floats]]:
            key = key_of(self._key, points, held)
            if key not in families:
                families[key] = [Family(results) for results in super().__call__(points, held)]
            return [iter(family) for family in families[key]]

    def remembered(setting: Setting, vertices: Floats, faces: Ints, **others: Any) -> Floats:
        key = key_of(setting, vertices, faces, *others.values())
        if key not in applied:
            applied[key] = apply(setting, vertices, faces, **others)
        return applied[key]

    module = vars(automatic)
    module["SettingsTried"], Setting.apply = Remembered, remembered  # type: ignore[method-assign, assignment]
    try:
        yield
    finally:
        module["SettingsTried"], Setting.apply = SettingsTried, apply  # type: ignore[method-assign]
