"""Ask a saved map what is where.

Make a map, then ask it:

    vizbot dry-run --explore --world 7 --out runs/home
    python examples/ask_saved_map.py runs/home/map "yellow chair" kitchen
"""

import argparse
from pathlib import Path

from mapping import map_bundle
from vizbot.config import Config
from vizbot.objectnav.tasks import goal_of
from vizbot.operator.session.place_answers import find_places
from vizbot.rig import open_map_encoder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", type=Path, help="folder of the map")
    parser.add_argument("text", nargs="+", help="what to look for")
    arguments = parser.parse_args()

    bundle = map_bundle.load(arguments.map)
    encoder = open_map_encoder(bundle, "cpu")
    bundle = map_bundle.with_background(bundle, encoder)

    for text in arguments.text:
        goal = goal_of(encoder, text)
        answer = find_places(bundle, goal, encoder.log_odds, Config().objectnav)
        print(text if goal.note is None else f"{text} ({goal.note})")
        for place in answer.places:
            x, y, z = place.position  # in the frame `map` [m]
            verdict = "found" if place.score > answer.threshold else "not likely enough"
            print(f"  {x:6.2f} {y:6.2f} {z:6.2f} m   probability {place.score:.0%}   {verdict}")


if __name__ == "__main__":
    main()
