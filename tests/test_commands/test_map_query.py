"""`vizbot map query`: which encoder it asks with."""

import json

import pytest

from mapping import map_bundle
from mapping.clip.reading import Reading
from tests.helpers.bundles import bundle_of
from vizbot.commands.map import query
from vizbot.commands.options import MapQueryOptions
from vizbot.core.errors import MapError


@pytest.fixture
def ask(tmp_path, monkeypatch, mean_colours):
    """Ask a saved map with some options; the encoder that was opened for it."""
    map_bundle.save(bundle_of(model_id=mean_colours.model_id), tmp_path / "home")
    opened = []

    def open_encoder(*wanted):
        opened.append(wanted)
        return mean_colours

    monkeypatch.setattr("vizbot.rig.require_encoder", lambda *_: None)
    monkeypatch.setattr("vizbot.rig.open_encoder", open_encoder)

    def command(**options):
        options = {"text": "yellow chair", "as_json": True} | options
        query(MapQueryOptions(tmp_path / "home", **options))
        return opened.pop()

    return command


@pytest.fixture
def answer(ask, capsys):
    """What a saved map answers as JSON, asked with some options."""

    def command(**options):
        ask(**options)
        return json.loads(capsys.readouterr().out)

    return command


def test_the_map_names_the_encoder_and_the_settings_say_where_it_runs(ask, tmp_path, capsys):
    assert ask() == ("mean-colours", "cpu", False)
    assert json.loads(capsys.readouterr().out)["text"] == "yellow chair"
    config = tmp_path / "robot.toml"
    config.write_text('clip = "ViT-B/32"\ndevice = "auto"\nhalf = true\n')
    assert ask(config=config) == ("mean-colours", "auto", True)
    assert ask(config=config, clip="ViT-L/14") == ("ViT-L/14", "auto", True)


def test_a_class_that_the_map_names_is_opened_where_a_person_names_it_too(
    ask, mean_colours, tmp_path, monkeypatch
):
    monkeypatch.setattr(mean_colours, "model_id", "mine:GoodOdds")
    map_bundle.save(bundle_of(model_id="mine:GoodOdds"), tmp_path / "home")
    with pytest.raises(MapError, match="if you trust it, name it: --clip mine:GoodOdds"):
        ask()
    (tmp_path / "robot.toml").write_text('clip = "other:Encoder"')
    with pytest.raises(MapError, match="--clip mine:GoodOdds"):
        ask(config=tmp_path / "robot.toml")
    (tmp_path / "robot.toml").write_text('clip = "mine:GoodOdds"')
    for options in ({"config": tmp_path / "robot.toml"}, {"clip": "mine:GoodOdds"}):
        assert ask(**options) == ("mine:GoodOdds", "cpu", False)


def test_how_the_encoder_reads_the_words_is_said(answer, mean_colours, monkeypatch):
    assert answer()["note"] is None
    note = "lemon: a kind of yellow"
    monkeypatch.setattr(type(mean_colours), "reading", lambda *_: Reading("yellow", note))
    said = answer()
    assert (said["text"], said["note"]) == ("yellow chair", note)


def test_by_the_papers_method_the_best_place_is_the_most_similar_element(
    answer, mean_colours, tmp_path
):
    elements = map_bundle.load(tmp_path / "home").elements
    best = (elements.embeddings @ mean_colours.embed_texts(["yellow chair"])[0]).max()
    said = answer(method="paper")
    similarities = [place["score"] for place in said["candidates"]]
    assert similarities == sorted(similarities, reverse=True)
    assert similarities[0] == pytest.approx(best, abs=1e-4)
    assert said["outcome"] == ("located" if best > said["threshold"] else "not_found")


def test_by_belief_the_answers_are_places_with_their_probabilities(answer):
    said = answer()
    probabilities = [place["score"] for place in said["candidates"]]
    assert probabilities == sorted(probabilities, reverse=True)
    assert 0.0 < probabilities[-1] <= probabilities[0] < 1.0
    assert said["threshold"] == 0.5
    assert said["outcome"] == ("located" if probabilities[0] > 0.5 else "not_found")


@pytest.mark.parametrize(
    ("text", "thing"),
    [
        ("Yellow Chair", "Yellow Chair"),
        ("where is the yellow chair?", "yellow chair"),
        ("is there a yellow chair?", "yellow chair"),
        ('"where is the sofa?"', "where is the sofa?"),
        ('"docking station"', "docking station"),
        ('where is the "stop sign"?', "stop sign"),
        ("find the yellow chair", "yellow chair"),
        ("something to sit on", "something to sit on"),
    ],
)
def test_a_question_asks_for_the_thing_in_it(answer, text, thing):
    about_the_thing = answer(text=thing if thing == "yellow chair" else f'"{thing}"')
    said = answer(text=text)
    assert (said["text"], said["count"]) == (thing, None)
    assert said == about_the_thing


@pytest.mark.parametrize(
    ("text", "english"),
    [
        ("der gelbe Stuhl", "yellow chair"),
        ("Wo ist der gelbe Stuhl?", "where is the yellow chair?"),
        ("Wie viele gelbe Stühle gibt es?", "how many yellow chairs are there?"),
    ],
)
def test_a_german_question_asks_for_the_same_as_an_english_one(ask, answer, capsys, text, english):
    same = answer(text=english) | {"text": "yellow chair"}
    ask(text=text, language="de")
    said = capsys.readouterr()
    assert json.loads(said.out) == same
    assert ": yellow chair" in said.err


def test_how_many_there_are_is_counted(ask, answer, capsys, tmp_path):
    scores = [place["score"] for place in answer()["candidates"]]
    config, counts = tmp_path / "robot.toml", []
    for found in (0.5, (scores[1] + scores[2]) / 2):
        config.write_text(f"[objectnav]\nanswer_probability = {found}\n")
        said = answer(text="how many yellow chairs are there?", config=config)
        counts.append(said["count"])
        assert said["text"] == "yellow chairs"
        ask(text="how many yellow chairs are there?", config=config, as_json=False)
        assert capsys.readouterr().out.startswith(f"yellow chairs: {counts[-1]} found (")
    assert counts == [0, 2]


@pytest.mark.parametrize("method", ["belief", "paper"])
def test_it_is_said_which_places_count(
    ask, answer, capsys, tmp_path, monkeypatch, mean_colours, method
):
    scores = [place["score"] for place in answer(method=method)["candidates"]]
    score = {"belief": "probability", "paper": "similarity"}[method]
    config = tmp_path / "robot.toml"
    for found, least in (("located", (scores[1] + scores[2]) / 2), ("not found", 0.999)):
        monkeypatch.setattr(mean_colours, "threshold", least)
        config.write_text(f"[objectnav]\nanswer_probability = {least}\n")
        ask(method=method, config=config, as_json=False)
        head, *rows = capsys.readouterr().out.splitlines()
        assert head == f"yellow chair: {found} (a place counts with a {score} above {least:.3g})"
        silent = [not row.endswith("does not count") for row in rows]
        assert silent == [each > least for each in scores]


def test_a_run_holds_its_map_in_a_folder_of_that_name(run, tmp_path):
    map_bundle.save(bundle_of(), tmp_path / "run" / "map")
    assert run("map", "info", "run") == run("map", "info", "run/map")
    assert run("map", "export", "run", "--format", "ply", "--out", "home.ply")[0] == 0
    assert "another" not in run("map", "query", "run", "sofa")[2]
    code, out, err = run("dry-run", "sofa", "--map", "run", "--base", "roomba")
    assert (code, out) == (1, "") and "serial port" in err


def test_a_folder_that_holds_no_map_is_named_as_it_was_given(run, tmp_path):
    (tmp_path / "run" / "map").mkdir(parents=True)
    assert run("map", "info", "run")[2].startswith("vizbot: run is not a map")
