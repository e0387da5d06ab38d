"""`beltsim schema`: the JSON schema of drive files.

Depends on: drive; cli.text.
"""

from __future__ import annotations

import argparse
import json

from beltsim.cli.text import say
from beltsim.drive import json_schema


def run(options: argparse.Namespace) -> int:  # noqa: ARG001 - all verbs are called alike
    """Print the schema; the exit status."""
    say(json.dumps(json_schema(), indent=2))
    return 0
