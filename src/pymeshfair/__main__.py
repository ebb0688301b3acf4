"""``python -m pymeshfair`` is the command ``pymeshfair``."""

from .commands.app import main

main()
