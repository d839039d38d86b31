"""Which cases of a test `make test` runs; the others are `long`."""

from collections import defaultdict
from collections.abc import Hashable

import pytest


def mark_the_rest_long(items):
    """Mark as `long` what the mark `sampled` leaves out of the cases of each test.

    It keeps the cases whose ids hold one of its words; where it has none, a few, so that each value
    of each parameter comes at least once.
    """
    tests = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sampled") and not item.get_closest_marker("long"):
            tests[item.nodeid.partition("[")[0]].append(item)
    for cases in tests.values():
        words = cases[0].get_closest_marker("sampled").args
        named = [each for each in cases if any(word in each.callspec.id for word in words)]
        kept = named or covering(cases)
        for case in cases:
            if case not in kept:
                case.add_marker(pytest.mark.long)


def covering(cases):
    """A few of the cases of a test, which have all values of its parameters."""
    values = [_values(case.callspec.params) for case in cases]
    missing, kept = set().union(*values), []
    while missing:
        best = max(range(len(cases)), key=lambda number: len(values[number] & missing))
        kept.append(cases[best])
        missing -= values[best]
    return kept


def _values(params):
    """The value of each parameter, or how it is written where it has no hash."""
    return {
        (name, value if isinstance(value, Hashable) else repr(value))
        for name, value in params.items()
    }
