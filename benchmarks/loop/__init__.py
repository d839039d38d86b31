"""The loop: what a tick of a rehearsal takes, alone and beside others, and how soon it starts."""
