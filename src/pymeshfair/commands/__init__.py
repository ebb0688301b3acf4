"""The command line: ``app`` assembles the commands, which are in the module of their subject."""

from ..garbage import collect_seldom

collect_seldom()  # before the imports of the commands
