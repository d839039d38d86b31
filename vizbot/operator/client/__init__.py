"""Programs that talk to a running robot over its API."""
