"""`make test` runs a sample of the cases of a test that is marked `sampled`."""

import itertools
from ast import literal_eval
from types import SimpleNamespace

import pytest

from tests.helpers.sampling import mark_the_rest_long


class Case:
    """A case of a test, as pytest collects it."""

    def __init__(self, test, indices, *marks):
        self.nodeid = f"{test}[{indices}]"
        params = {number: {"index": index} for number, index in enumerate(indices)}
        self.callspec = SimpleNamespace(id=str(indices), params=params)
        self.marks = {mark.name: mark for mark in marks}

    def get_closest_marker(self, name):
        return self.marks.get(name)

    def add_marker(self, decorator):
        self.marks[decorator.mark.name] = decorator.mark


def product(test, sizes, *marks):
    return [Case(test, indices, *marks) for indices in itertools.product(*map(range, sizes))]


def kept(cases):
    mark_the_rest_long(cases)
    return [each.callspec.id for each in cases if "long" not in each.marks]


def test_each_value_of_each_parameter_comes_at_least_once():
    cases = product("test_a", (11, 8, 2), pytest.mark.sampled.mark)
    left = kept(cases)
    assert len(left) == 11
    for parameter, size in enumerate((11, 8, 2)):
        assert {literal_eval(each)[parameter] for each in left} == set(range(size))


def test_cases_with_a_word_are_kept_for_each_test_apart_and_others_as_they_are():
    named = product("test_a", (3, 2), pytest.mark.sampled("2, 1", "(0, 0)").mark)
    plain = product("test_b", (3,))
    assert kept([*named, *plain]) == ["(0, 0)", "(2, 1)", "(0,)", "(1,)", "(2,)"]


def test_what_names_no_case_keeps_each_value_and_what_is_long_stays_long():
    mark = pytest.mark.sampled("renamed").mark
    assert len(kept(product("test_a", (3, 2), mark))) == 3
    assert kept(product("test_a", (3, 2), mark, pytest.mark.long.mark)) == []
