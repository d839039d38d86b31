"""The embedded CLIP: a small real encoder for rehearsals, with its weights."""
