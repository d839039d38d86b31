"""Of how many sentences of each table what must happen does."""

import pytest

from tests.tools.sentences import FOLDER, LEAST, tried

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.tsv")), ids=lambda path: path.stem)
def test_sentences_lead_to_what_they_ask_for(path):
    count, wrong, drove = tried(path)
    assert drove == [], "it drives where nobody asked it to"
    assert count - len(wrong) >= round(LEAST.get(path.stem, 1.0) * count), wrong
