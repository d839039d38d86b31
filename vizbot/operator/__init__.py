"""What a person uses: console, API, teleop, voice, viewer and report."""
