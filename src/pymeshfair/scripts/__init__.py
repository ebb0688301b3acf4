"""Filter scripts (.mlx): read, check, upgrade and write."""

from .read import parse_script, read_script
from .script import Change, Problem, Script, ScriptError, Setting, Step, checked_name
from .upgrade import Upgrade, upgrade_script
from .write import format_script, write_script

__all__ = [
    "Change",
    "Problem",
    "Script",
    "ScriptError",
    "Setting",
    "Step",
    "Upgrade",
    "checked_name",
    "format_script",
    "parse_script",
    "read_script",
    "upgrade_script",
    "write_script",
]
