"""Where tests find the data they read and the pages they check."""

from pathlib import Path

TESTS = Path(__file__).parent
ROOT = TESTS.parent
DATA, CORPUS, DOCS = TESTS / "data", TESTS / "corpus", ROOT / "docs"
RECORDINGS = ROOT / "studies" / "laboratory" / "recordings"
