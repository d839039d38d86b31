"""What `vizbot` and `python -m vizbot` run: the command line, and the end of the process."""

from __future__ import annotations

import atexit
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from vizbot.cli.standard_error import lose_what_cannot_be_written
from vizbot.core.errors import VizbotError
from vizbot.operator.client.stop import HERE, send_stop


def run() -> NoReturn:
    """Run the command line and end the process.

    Whatever was open is closed then, but threads may still be in native code: an embedding, a wait
    for a line of standard input. Python would take the interpreter apart under them, which now and
    then ends in a segmentation fault. Exit functions run, and nothing else; Ctrl-C ends a program
    that waits for them.
    """
    code: int | str | None = None
    try:
        if sys.argv[1:2] == ["stop"]:
            code = _stop(sys.argv[2:])
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


def _stop(arguments: Sequence[str]) -> int | None:
    """Stop the robot that the arguments of `vizbot stop` name.

    Returns:
        The exit code; None where the arguments are more than an address and a token, which the
        whole command line reads.
    """
    url, words = os.environ.get("VIZBOT_URL") or HERE, list(arguments)
    while words:
        option, given, value = words.pop(0).partition("=")
        if option not in ("--url", "--token") or not (given or words):
            return None
        value = value if given else words.pop(0)
        if not value.isascii() or not value.isprintable() or value.startswith("-"):
            return None
        url = value if option == "--url" else url
    lose_what_cannot_be_written()
    try:
        send_stop(url)
    except KeyboardInterrupt:
        print("vizbot: interrupted", file=sys.stderr)
        return 130
    except VizbotError as error:
        line = " ".join(str(error).splitlines())
        shown = (c if c.isprintable() else f"\\u{ord(c):04x}" for c in line)
        print(f"vizbot: {''.join(shown)}", file=sys.stderr)
        return 1
    print("stopped")
    return 0
