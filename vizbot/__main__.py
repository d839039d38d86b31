"""`python -m vizbot`: the command line, as `vizbot` itself."""

from vizbot.cli.app import main

main()
