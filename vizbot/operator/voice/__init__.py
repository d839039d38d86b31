"""Speech and sentences: from sound to a command."""
