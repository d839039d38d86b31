"""Train the embedded CLIP: `python -m sim_stubs.clip.training FOLDER`."""

import typer

from sim_stubs.clip.training.training import train_embedded_clip

typer.run(train_embedded_clip)
