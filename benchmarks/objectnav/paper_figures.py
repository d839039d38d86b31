"""The paper's own figures [%], quoted beside ours; none of these methods was run here.

Taguchi and Deguchi, "Online Embedding Multi-Scale CLIP Features into 3D Maps".
"""

MARK = "paper, not run here"
HEAD = "paper, in other homes: no direct comparison"
"""Mark of a column of its figures beside ours."""

OBJECT_NAVIGATION = (
    ("YOLOv8", 25.9, 53.8, 0.0),
    ("Detic", 29.6, 50.0, 10.7),
    ("VLMap", 50.0, 46.2, 53.6),
    ("Ours, ViT-B/32", 64.8, 61.5, 67.9),
    ("Ours, ViT-L/14", 87.0, 80.8, 92.9),
)
"""Method, success of all, of objects in COCO, of others (Table I; 54 episodes)."""

SCALES = (
    ((1,), 1, 75.9),
    ((0,), 4, 77.8),
    ((-1,), 20, 72.2),
    ((-2,), 88, 51.9),
    ((1, 0), 5, 79.6),
    ((1, 0, -1), 25, 87.0),
    ((1, 0, -1, -2), 113, 85.2),
)
"""Scales, features per image, success of navigation with ViT-L/14 (ablation study)."""

RETRIEVAL = (
    ("VLMap, raw", 50.0, 46.2, 53.6),
    ("VLMap, normalized", 85.2, 88.5, 82.1),
    ("Ours, ViT-B/32", 74.1, 69.2, 78.6),
    ("Ours, ViT-L/14", 83.3, 80.8, 85.7),
)
"""Method, precision@1 of all, of objects in COCO, of others."""

MULTI = (
    ("VLMap", (52, 31, 18, 14)),
    ("Ours, ViT-B/32", (68, 35, 20, 12)),
    ("Ours, ViT-L/14", (96, 65, 44, 37)),
)
"""Method, episodes of 100 that reach at least 1, 2, 3, 4 goals."""
