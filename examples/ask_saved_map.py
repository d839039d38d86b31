"""Ask a saved map what is where.

Make a map, then ask it:

    vizbot dry-run --explore --world 7 --out runs/home
    python examples/ask_saved_map.py runs/home/map "yellow chair" kitchen
"""

import argparse
from pathlib import Path

from mapping import map_bundle
from mapping.clip.retrieval import best, similarities
from vizbot.objectnav.tasks import goal_of
from vizbot.rig import open_encoder

PLACES = 3
SPACING = 1.0
"""Places closer than this [m] count as one."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", type=Path, help="folder of the map")
    parser.add_argument("text", nargs="+", help="what to look for")
    arguments = parser.parse_args()

    bundle = map_bundle.load(arguments.map)
    encoder = open_encoder(bundle.model_id, "cpu")
    points = bundle.element_points()  # (N, 3) in the frame `map` [m]

    for text in arguments.text:
        goal = goal_of(encoder, text)
        scores = similarities(bundle.elements.embeddings, goal.embedding)
        print(text if goal.note is None else f"{text} ({goal.note})")
        for i in best(scores, points, PLACES, SPACING):
            x, y, z = points[i]
            verdict = "found" if scores[i] > goal.threshold else "not similar enough"
            print(f"  {x:6.2f} {y:6.2f} {z:6.2f} m   similarity {scores[i]:.3f}   {verdict}")


if __name__ == "__main__":
    main()
