"""The command line: ``app`` puts the commands together, each in the module of its subject."""

from ..garbage import collect_seldom

collect_seldom()  # before what the commands import
