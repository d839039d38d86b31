"""How many sentences of each table lead to what they ask for.

python -m tests.tools.sentences
"""

from __future__ import annotations

from tests.helpers.sentences import FOLDER, tried
from vizbot.operator.printing import echo


def main() -> None:
    for path in sorted(FOLDER.glob("*.tsv")):
        count, wrong, drove = tried(path)
        echo(f"{path.stem}: {count - len(wrong)} of {count} right, {len(drove)} drive unasked")
        for line in wrong:
            echo(f"  {line}")


if __name__ == "__main__":
    main()
