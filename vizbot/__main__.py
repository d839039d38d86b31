"""`python -m vizbot`: the command line, as `vizbot` itself."""

import sys
from pathlib import Path

# Python looks in the working folder first: somebody's `nav.py` there would stand for our folder.
if not sys.flags.safe_path:
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from vizbot.cli.process import run

run()
