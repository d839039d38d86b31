"""What a person may ask for in a home before a map has said what it knows."""

from __future__ import annotations

HOUSEHOLD: tuple[str, ...] = (
    "armchair", "backpack", "bathroom", "bathtub", "bed", "bedroom", "bench", "bicycle",
    "black suitcase", "blue armchair", "bookshelf", "bottle", "brown wardrobe", "bunk bed",
    "cardboard box", "carpet", "chair", "chest of drawers", "clock", "coffee machine",
    "coffee table", "computer", "crib", "cup", "curtain", "desk", "dining table", "door",
    "dryer", "electric fan", "fireplace", "floor lamp", "green plant", "guitar", "hallway",
    "keyboard", "kid's room", "kitchen", "kitchen cabinet", "lamp", "laptop",
    "laundry basket", "laundry room", "living room", "microwave", "mirror", "nightstand",
    "office chair", "oven", "piano", "picture", "plant", "printer", "radiator", "red sofa",
    "refrigerator", "shelf", "shower", "sink", "sofa", "stairs", "stool", "study", "suitcase",
    "table", "table lamp", "teddy bear", "television", "toilet", "trash can", "umbrella",
    "vacuum cleaner", "vase", "wardrobe", "washing machine", "white table", "window",
    "yellow chair",
)  # fmt: skip
"""Things and rooms, in alphabetical order."""
