from sim_stubs.homes.furniture.catalogue import CATALOGUE, CLASSES, Entry, instances
from sim_stubs.homes.furniture.source import DESIGNS, counts, design_of, split
from tests.test_homes.test_furniture import REAL, needs_package


def entry(id, name="Chair", height=0.9):
    size = (0.5, 0.5, height)
    return Entry(id, name, "Living room", size, 0.0, (), "Nobody", "CC0", CATALOGUE, "x.obj")


def chairs(count):
    return tuple(entry(f"Test#chair{i}") for i in range(count))


def test_seven_of_ten_models_are_to_train_on():
    training, held_out = split(chairs(10))
    assert len(training) == 7
    assert {*training, *held_out} == {*chairs(10)} and len(held_out) == 3


def test_which_they_are_is_told_by_their_ids_alone():
    assert split(chairs(10)[::-1])[0][::-1] == split(chairs(10))[0]
    assert split(chairs(10))[0] != chairs(7)


def test_two_models_are_one_on_each_side_and_a_single_one_is_held_out():
    assert [len(side) for side in split(chairs(2))] == [1, 1]
    assert split(chairs(1)) == ((), chairs(1))


def test_models_of_no_class_are_on_neither_side():
    assert split((entry("Test#x", "Spaceship"),)) == ((), ())


def test_a_model_of_several_classes_is_on_one_side_only():
    tables = tuple(entry(f"Test#t{i}", "Table", 0.75 if i % 2 else 0.45) for i in range(9))
    training, held_out = split(tables)
    assert not {*training} & {*held_out}
    for label in ("table", "coffee table", "dining table"):
        assert instances(label, training) and instances(label, held_out)


def test_models_of_one_design_stay_together():
    cabinets = tuple(entry(id, "Lower cabinet") for id in DESIGNS[0])
    others = tuple(entry(f"Test#{i}", "Lower cabinet") for i in range(6))
    sides = split((*cabinets, *others))
    assert sorted(sum(it in cabinets for it in side) for side in sides) == [0, len(cabinets)]


@needs_package
def test_every_design_is_of_models_of_the_package():
    listed = [id for design in DESIGNS for id in design]
    assert len(listed) == len({*listed})
    assert {*listed} <= {entry.id for entry in REAL}


@needs_package
def test_every_class_of_the_package_has_looks_on_both_sides():
    training, held_out = split(REAL)
    assert not {design_of(it) for it in training} & {design_of(it) for it in held_out}
    for label, count in counts(REAL).items():
        assert count.training + count.shapes > 0, label
        assert count.held_out > 0 or count.shapes, label
        designs = {design_of(it) for it in instances(label, REAL)} if label in CLASSES else set()
        if len(designs) > 1:
            assert count.training > 0 and count.held_out > 0, label


@needs_package
def test_there_are_at_least_sixty_classes_with_held_out_models():
    assert sum(count.held_out > 0 for count in counts(REAL).values()) >= 60
