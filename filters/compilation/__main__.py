"""``python -m pymeshfair.filters.compilation``: compiles all that is listed into the store; for the installation."""

import sys

from .ahead import compile_ahead, listed_signatures

if __name__ == "__main__":
    failures = compile_ahead(listed_signatures())
    print("\n".join(failures), file=sys.stderr)
    sys.exit(bool(failures))
