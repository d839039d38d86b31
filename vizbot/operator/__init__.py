"""What a person uses: reports, and later the console, voice and teleoperation."""
