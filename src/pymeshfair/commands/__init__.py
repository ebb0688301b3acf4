"""The command line: ``app`` puts the commands together, one module a command."""

from ..garbage import collect_seldom

collect_seldom()  # before what the commands import
