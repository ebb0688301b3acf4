"""Filter scripts (.mlx): read, check and write."""

from .problems import Problem, ScriptError
from .read import parse_script, read_script
from .script import Script, Step
from .write import format_script, write_script

__all__ = ["Problem", "Script", "ScriptError", "Step", "format_script", "parse_script", "read_script", "write_script"]
