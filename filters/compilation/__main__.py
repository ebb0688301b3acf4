"""``python -m pymeshfair.filters.compilation``: compiles the listed kernels into the store, at installation."""

import sys

from .ahead import compile_ahead, listed_signatures

if __name__ == "__main__":
    failures = compile_ahead(listed_signatures())
    print("\n".join(failures), file=sys.stderr)
    sys.exit(bool(failures))
