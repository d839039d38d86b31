"""`python -m vizbot`: the command line, as `vizbot` itself."""

from vizbot.cli.process import run

run()
