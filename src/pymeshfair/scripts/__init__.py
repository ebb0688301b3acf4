"""Filter scripts (.mlx): read, check, upgrade and write."""

from .read import parse_script as parse_script
from .read import read_script as read_script
from .script import Change as Change
from .script import Problem as Problem
from .script import Script as Script
from .script import ScriptError as ScriptError
from .script import Setting as Setting
from .script import Step as Step
from .script import checked_name as checked_name
from .script import clean_comment as clean_comment
from .upgrade import Upgrade as Upgrade
from .upgrade import upgrade_script as upgrade_script
from .write import format_script as format_script
from .write import write_script as write_script
