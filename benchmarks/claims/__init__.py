"""Figures on README and pages, held against the kept rows that they come from."""
