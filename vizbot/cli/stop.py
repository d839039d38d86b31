"""`vizbot stop`: sent before the command line itself is loaded."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from vizbot.cli.standard_error import lose_what_cannot_be_written
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.operator.client.stop import HERE, send_stop


def main(arguments: Sequence[str]) -> int | None:
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
    except (ConfigError, DeviceError) as error:
        line = " ".join(str(error).splitlines())
        shown = (c if c.isprintable() else f"\\u{ord(c):04x}" for c in line)
        print(f"vizbot: {''.join(shown)}", file=sys.stderr)
        return 1
    print("stopped")
    return 0
