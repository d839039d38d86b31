"""Background phrases: what else a patch may show, to judge how unusual a similarity is.

They name things, stuff and rooms of homes and offices, or say nothing in particular. A question is
compared with all of them (`mapping.clip.scores`), so that the units of an encoder do not matter. A
place is in one room alone: evidence for another room there is evidence against the one that is
asked for (`mapping.clip.places.belief`). That does not hold for things: a place may show a sofa and
a cushion.
"""

from __future__ import annotations

from hashlib import sha256

_THINGS = """
alarm clock, apple, armchair, backpack, bag, ball, banana, basket, bath mat, bathtub, bed, bench,
bicycle, blanket, blinds, board game, book, bookshelf, bottle, bowl, box, broom, bucket, cabinet,
cable, calendar, candle, car, cardboard box, carpet, cat, chair, chest of drawers, clothes, clothes
rack, coat rack, coffee machine, coffee table, computer, cup, cupboard, curtain, cushion, desk,
dining table, dish rack, dishwasher, dog, door, door handle, drawer, dryer, dumbbell, electric fan,
extractor hood, faucet, fire extinguisher, fireplace, flower, flower pot, fork, freezer, guitar,
hair dryer, hammer, hanger, hat, headphones, houseplant, iron, ironing board, jacket, kettle, key,
keyboard, kitchen counter, knife, ladder, lamp, laptop, light switch, magazine, mattress, microwave,
mirror, mop, mug, newspaper, nightstand, office chair, oven, painting, pan, paper, pen, person,
piano, picture frame, pillow, plate, poster, pot, power outlet, printer, radiator, refrigerator,
remote control, rug, scissors, screen, shelf, shoe, shoe rack, shower, shower curtain, sink, soap,
sofa, speaker, stairs, statue, stool, stove, suitcase, table, teddy bear, telephone, television,
tissue box, toaster, toilet, toilet paper, tool, toothbrush, towel, toy, trash can, tripod,
umbrella, vacuum cleaner, vase, ventilator, wardrobe, washing machine, water dispenser, whiteboard,
window, wine glass
"""
_STUFF = """
bricks, carpeted floor, concrete, fabric, glass, grass, leather, marble, metal, plaster, plastic,
sky, stone, tiles, wallpaper, water, white paint, wood, wooden floor
"""
_ROOMS = """
attic, balcony, basement, bathroom, bedroom, child's room, corridor, dining room, entrance, garage,
garden, hallway, kitchen, laundry room, library, living room, meeting room, office, staircase,
storeroom, study, toilet room
"""
_EMPTY = """
an object, a thing, a part of something, a texture, a pattern, a surface, a wall, a floor, a
ceiling, a corner, an edge, a shadow, a reflection, a room, furniture, a doorway, a blurred picture,
a dark picture, a bright picture, a close-up, a photo, a picture of a home, an empty room, clutter,
nothing
"""

_KINDS = (
    ("living room", "lounge"),
    ("kitchen", "dining room"),
    ("bathroom", "toilet room", "shower room"),
    ("bedroom", "child's room", "kid's room", "nursery", "guest room"),
    ("hallway", "corridor", "entrance", "foyer"),
    ("office", "study", "library", "meeting room"),
    ("laundry room", "storeroom", "utility room"),
)
"""Names of rooms that are hard to tell from one another; the first stands for the others."""


def _listed(text: str) -> tuple[str, ...]:
    return tuple(name for each in text.split(",") if (name := " ".join(each.split())))


PHRASES = (*_listed(_THINGS), *_listed(_STUFF), *_listed(_ROOMS), *_listed(_EMPTY))
"""Some 200 phrases with which a similarity is compared."""
PHRASES_ID = sha256("\n".join(PHRASES).encode()).hexdigest()[:12]
"""Names the list: statistics over another one must not be mixed with these."""


def other_rooms(text: str) -> tuple[str, ...]:
    """The rooms that a place is not if it is the room that a text names; none for a thing.

    Args:
        text: Words of which the last ones name what is asked for.
    """
    words = f" {' '.join(text.casefold().split())}"
    asked = [kind for kind in _KINDS if any(words.endswith(f" {name}") for name in kind)]
    return tuple(kind[0] for kind in _KINDS if kind not in asked) if asked else ()
