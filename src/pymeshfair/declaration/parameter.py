"""The base class of all kinds of parameter."""

import typing
import warnings
from dataclasses import dataclass
from typing import Any

from ..errors import ParameterError
from .units import Length
from .values import as_float, shown

#: the word for a value that the filter chooses for the mesh
AUTO = "auto"


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a filter.

    Attributes:
        name: the Python name, which is also the name in .mlx scripts unless `xml_name` says otherwise.
        label: the words before the input field in a dialog; those of the name if it is empty.
        help: the tooltip: what it means, in which unit, and which direction does what.
        default: the value when none is given; None in a built-in filter whose default depends on the mesh.
        advanced: whether a dialog hides it at first.
        xml_name: the name in .mlx scripts, MeshLab's C++ name.
        automatic: the number that stands for "auto" where nothing else can: in .mlx scripts, whose types are MeshLab's, and for
            the filter's function. None if nothing is automatic.
    """

    name: str = ""
    label: str = ""
    help: str = ""
    default: Any = None
    advanced: bool = False
    xml_name: str = ""
    automatic: float | None = None

    #: the word for the kind of value in messages, e.g. "a whole number"
    kind: typing.ClassVar[str] = "a value"
    #: MeshLab's class of the parameter and the name of that class in .mlx scripts
    rich_type: typing.ClassVar[str] = ""
    xml_type: typing.ClassVar[str] = ""
    #: the type that a filter's function receives
    python_type: typing.ClassVar[Any] = object

    def check(self, value: Any) -> Any:
        """The value in the type that the filter receives; raise `ParameterError` if it is not one the parameter allows."""
        raise NotImplementedError

    def describe_allowed(self) -> str:
        """The allowed values, in words: ``"a whole number of at least 1"``."""
        return self.kind

    def from_number(self, value: Any) -> Any:
        """The value, or "auto" in place of the number that stands for it."""
        return AUTO if self.automatic is not None and as_float(value) == self.automatic else value

    def to_number(self, value: Any) -> Any:
        """The value, or in place of "auto" the number that stands for it."""
        return self.automatic if self.automatic is not None and isinstance(value, str) and value == AUTO else value

    def is_automatic(self, value: Any) -> bool:
        """Whether the value is "auto", or the number that stands for it: an old spelling, with a `FutureWarning`."""
        if self.automatic is None or not isinstance(self.from_number(value), str):
            return False
        if not isinstance(value, str):
            text = value if isinstance(value, Length) else f"{value:g}"
            warnings.warn(f"parameter {self.name!r}: write 'auto' in place of {text}", FutureWarning, stacklevel=4)
        return bool(self.from_number(value) == AUTO)

    def refusal(self, value: Any) -> ParameterError:
        """The error that says what is allowed and what came."""
        return ParameterError(
            f"parameter {self.name!r} takes {self.describe_allowed()}, got {value if isinstance(value, Length) else shown(value)}"
        )

    def refuse_what_meshlab_cannot_hold(self, number: float) -> None:
        """Raise `ParameterError` for a number that MeshLab would lose."""
        # MeshLab's parameters are C floats; it drops a script's number outside their range without a word.
        if number != 0.0 and not 2.0**-150 < abs(number) <= 3.4028234663852886e38:
            raise ParameterError(f"{self.refusal(number)}: MeshLab keeps numbers in single precision, from 1e-45 to 3.4e38")
