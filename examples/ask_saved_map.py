"""Ask a saved map what is where.

Make a map, then ask it:

    vizbot dry-run --explore --world 7 --out runs/home
    python examples/ask_saved_map.py runs/home/map "yellow chair" kitchen
"""

import argparse

from vizbot import SavedMap


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", help="folder or name of the map")
    parser.add_argument("text", nargs="+", help="what to look for")
    arguments = parser.parse_args()

    saved = SavedMap(arguments.map)
    for text in arguments.text:
        answer = saved.find(text)
        print(text if answer.note is None else f"{text} ({answer.note})")
        for place in answer.places:
            x, y, z = place.position  # in the frame `map` [m]
            verdict = "found" if place.score > answer.threshold else "not likely enough"
            print(f"  {x:6.2f} {y:6.2f} {z:6.2f} m   probability {place.score:.0%}   {verdict}")


if __name__ == "__main__":
    main()
