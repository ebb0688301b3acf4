"""The few settings that are run in full on a scan: what held-out vertices chose, and what becomes of outliers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..evidence import Choice, folded_share, folds_cost_more, sizes_beside, upright
from ..mesh import Bools, Floats, Ints
from ..topology import BorderPolicy
from .candidates import SettingsTried
from .impulses import Outliers, far_from, replace_outlying
from .noise_level import smooth_normals
from .relaxation import direction_for
from .repertoire import Repertoire, Setting, settings
from .scan import Scan
from .tangential_shift import TangentialShift

# More vertices than this stand out of impulsive noise: of Gaussian noise up to 0.003, of clean meshes up to 0.007.
_IMPULSIVE = 0.01
# Noise may be uneven where more vertices than this share stand out. Beside spikes the others are as far off as elsewhere, up to
# 1.1 times. Where uneven noise stands out they are 1.2 times as far off and more, and by more mean edges than details are.
_STAND_OUT, _LOUDER, _LOUD = 0.005, 1.2, 0.05
# Fewer faces folded over than this share cost less than evening out a ball does, see `folds_cost_more`.
_FOLDED = 0.0005


@dataclass(frozen=True, eq=False)
class ComparedSettings:
    """Settings tried on a scan.

    Filters that keep edges keep vertices that stand out, and those that have slid along the surface. So, if there are outliers:

    1. They are replaced by what the others expect before settings are tried, and are no evidence, unless all are off beside them,
       as where noise is uneven. Where the others are nearly exact, see `Scan.exact`, nothing but they is to move: this is tried.
    2. What is found is compared with the same setting that keeps outliers.
    3. If outliers have slid along the surface and it leaves faces folded over, others have slid too: settings whose steps of
       Taubin's even that out are tried as well, and instead of it if `folds_cost_more`.

    Attributes:
        scan: the scan.
        border: see `normal_filtering`.
        repertoire: what is chosen from.
    """

    scan: Scan
    border: BorderPolicy
    repertoire: Repertoire
    _results: dict[Setting, Floats] = field(default_factory=dict)

    def found(self) -> dict[Setting, Choice[Setting] | None]:
        """The settings that are to be compared, each with what speaks for it; the first keeps outliers."""
        scan = self.scan
        calmed, outlying = replace_outlying(scan.points, scan.faces, scan.movable)
        uneven = self._uneven(calmed, outlying)
        may = not uneven and self.repertoire.outliers != "keep"
        if may and np.mean(outlying) > _IMPULSIVE:
            return self._without(calmed, outlying)
        evidence = self._tried_on(scan, self.repertoire, certain=uneven)
        setting = Setting() if evidence is None else evidence.chosen.label
        found = {setting: evidence}
        if may and np.mean(far_from(scan.points, scan.faces, self._in_full(setting))) > _IMPULSIVE:
            found[replace(setting, outliers="replace")] = evidence
        return found

    def _uneven(self, calmed: Floats, outlying: Bools) -> bool:
        """Whether outliers, which are `calmed`, are where noise is loud, and not spikes: half a mesh of noise is none."""
        if np.mean(outlying) <= _STAND_OUT:
            return False
        beside, elsewhere = sizes_beside(calmed, self.scan.faces, self.scan.normals, outlying, self.scan.scored)
        return beside > max(_LOUDER * elsewhere, _LOUD)

    def _without(self, calmed: Floats, outlying: Bools) -> dict[Setting, Choice[Setting] | None]:
        """Those for a scan with outliers, whose points are `calmed` where these are replaced."""
        rest = replace(self.scan, points=calmed, replaced=outlying)
        evidence = self._tried_on(rest, self.repertoire)
        setting = Setting(outliers="only") if evidence is None else evidence.chosen.label
        found = {replace(setting, outliers="keep"): evidence, setting: evidence}
        folded = self._folded(setting)
        if folded <= _FOLDED or not any(self.repertoire.relaxations) or not self._shifted_along(outlying, setting):
            return found
        evening = self._tried_on(rest, self.repertoire.evening)
        if evening is not None:
            evens = evening.chosen.label
            found[evens] = evening
            even = self._in_full(evens)
            again = self._result(even, replace(evens, outliers="keep"))
            if folds_cost_more(folded - self._folded(evens), even, again, self.scan.faces):
                del found[setting]
        return found

    def _tried_on(self, scan: Scan, repertoire: Repertoire, *, certain: bool = False) -> Choice[Setting] | None:
        """What the held-out vertices say of all settings; None if they say nothing, or nothing is to be done.

        Where noise is `certain` what is calm does not tell how strong it is.
        """
        replaced = scan.replaced
        if replaced is None and scan.clean:
            return None
        direction = repertoire.relaxation_direction or direction_for(scan.noise)
        # What moves nothing but outliers has no steps of Taubin's.
        alone = replaced is not None and scan.exact and 0 in repertoire.relaxations
        tried = SettingsTried(
            scan.faces,
            scan.normals,
            direction,
            border=self.border,
            movable=scan.movable,
            replaced=replaced if alone else None,
            whole=scan.whole,
            of=repertoire,
        )
        outliers: Outliers = "keep" if replaced is None else "replace"
        evidence = scan.choose(tried, settings(direction, outliers, alone=alone, of=repertoire), spikes=alone)
        return evidence if evidence is None or certain or replaced is not None else scan.or_nothing(evidence)

    def best_of(self, few: Sequence[Setting]) -> Setting:
        """Which of them, run in full, the held-out vertices speak for; none that leaves many faces folded over, see `upright`."""
        if len(few) == 1:
            return few[0]
        left = [s for s, stays in zip(few, upright([self._folded(s) for s in few]), strict=True) if stays or s == Setting()]
        if len(left) == 1:
            return left[0]

        def candidates(points: Floats, held: Ints) -> list[Iterator[Floats]]:
            certain = np.zeros(len(points), dtype=np.bool_)
            certain[held] = True
            # Each is run when it is read: what has fallen behind is not.
            return [(self._result(points, s, certain) for s in [setting]) for setting in left]

        found = self.scan.choose(candidates, [[setting] for setting in left], spikes=True)
        return left[0] if found is None else found.chosen.label

    def _folded(self, setting: Setting) -> float:
        """The share of the faces that it leaves folded over."""
        return folded_share(self._in_full(setting), self.scan.faces, self.scan.normals)

    def _shifted_along(self, outlying: Bools, setting: Setting) -> bool:
        """Whether outliers are off along the surface that the setting makes of the scan."""
        normals = smooth_normals(self._in_full(setting), self.scan.faces)
        return TangentialShift.of(self.scan.points, self.scan.faces, normals, outlying).share > 0.0

    def _in_full(self, setting: Setting) -> Floats:
        """(n, 3) what the setting makes of the scan, found once."""
        if setting not in self._results:
            self._results[setting] = self._result(self.scan.points, setting)
        return self._results[setting]

    def _result(self, points: Floats, setting: Setting, certain: Bools | None = None) -> Floats:
        """(n, 3) what the setting makes of the points."""
        return setting.apply(points, self.scan.faces, border=self.border, movable=self.scan.movable, certain=certain)
