"""vizbot: a Roomba with an RGB-D camera that understands a home."""

__version__ = "0.1.0"
