"""Connections to the API: who is let in, how fast, and which requests are whole."""
