"""What `vizbot` and `python -m vizbot` run: the command line, and the end of the process."""

from __future__ import annotations

import atexit
import os
import signal
import sys
from contextlib import suppress
from typing import NoReturn

from vizbot.cli import stop


def run() -> NoReturn:
    """Run the command line and end the process.

    Whatever was open is closed then, but threads may still be in native code: an embedding, a wait
    for a line of standard input. Python would take the interpreter apart under them, which now and
    then ends in a segmentation fault. What is to be done at the exit is done, and nothing else;
    who does not want to wait for that ends it by Ctrl-C.
    """
    code: int | str | None = None
    try:
        if sys.argv[1:2] == ["stop"]:
            code = stop.main(sys.argv[2:])
        if code is None:
            from vizbot.cli.app import main  # loads what a stop does without

            main()
    except SystemExit as end:
        code = end.code
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # nobody may listen, or it is closed
            stream.flush()
    os._exit(code if isinstance(code, int) else int(code is not None))
