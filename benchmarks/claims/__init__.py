"""Compares figures on README and pages with the kept rows that they come from."""
