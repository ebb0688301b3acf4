"""What the border of an open mesh does while the rest is smoothed."""

from typing import Literal, TypeAlias, get_args

#: "fixed": border vertices stay. "along": they see their neighbours on the border only, so the border is smoothed as a curve.
#: "free": they are vertices like any other, and the border draws in.
BorderPolicy: TypeAlias = Literal["fixed", "along", "free"]
BORDER_POLICIES: tuple[BorderPolicy, ...] = get_args(BorderPolicy)
