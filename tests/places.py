"""Where tests find the data they read and the pages they check."""

import re
from pathlib import Path

TESTS = Path(__file__).parent
ROOT = TESTS.parent
DATA, CORPUS, DOCS = TESTS / "data", TESTS / "corpus", ROOT / "docs"
RECORDINGS = ROOT / "studies" / "laboratory" / "recordings"

# the shipped scenarios that are not of a mechanism, which takes a minute to compile
OF_THE_PAIR = ("paper-clean", "paper-noisy", "tuned", "challenge", "slack", "slack-deep", "activation")

# what a page shows as it is: fenced code
FENCED = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def contents(folder: Path) -> dict[str, bytes]:
    """Name → content of what is in a folder, but for the list of what hillobs has written there."""
    there = [path for path in folder.iterdir() if not path.name.startswith(".hillobs-")]
    return {path.name: path.read_bytes() if path.is_file() else b"" for path in there}


def anchors(page: Path) -> set[str]:
    """What may stand behind # in a link to `page`: its headings as GitHub names them."""
    found: set[str] = set()
    for heading in re.findall(r"^#{1,6} +(.+?) *$", FENCED.sub("", page.read_text(encoding="utf-8")), re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        again = [f"{slug}-{i}" for i in range(1, 100)]
        found.add(next(name for name in (slug, *again) if name not in found))
    return found
