"""Train the embedded CLIP: `python -m training FOLDER`."""

import typer

from training.training import train_embedded_clip

typer.run(train_embedded_clip)
