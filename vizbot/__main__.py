"""`python -m vizbot`: the command line, as `vizbot` itself."""

import sys

# Python looks in the working folder first: somebody's `nav.py` there would stand for our folder.
if not sys.flags.safe_path:
    sys.path[0] = __file__.rpartition("/vizbot/")[0]

from vizbot.cli.process import run

run()
