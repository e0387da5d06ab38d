"""`python -m beltsim`: the command line.

Depends on: cli.
"""

from __future__ import annotations

import sys

from beltsim.cli import main

if __name__ == "__main__":
    sys.exit(main())
