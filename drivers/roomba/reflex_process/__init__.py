"""The process of the reflexes: the link to it, the channel between, and its watchdog."""
