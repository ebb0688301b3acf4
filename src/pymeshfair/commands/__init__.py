"""The command line: ``app`` assembles the commands; each is in the module of its subject."""

from ..garbage import collect_seldom

collect_seldom()  # before the imports of the commands
