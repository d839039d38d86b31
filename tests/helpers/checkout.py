"""Where the sources and the real recording lie, for every test that needs them."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
"""The folder that holds the import packages and `tests`."""
OFFICE_WALK = ROOT.parent / "shared" / "data" / "hololens_office"
"""A real RGB-D walk in TUM layout; tests that replay it are skipped where it is missing."""
