"""Words that the glossary replaces are counted where they are, and may only become fewer."""

from __future__ import annotations

import runpy
from pathlib import Path

ROOT = Path(__file__).parents[1]
GLOSSARY = runpy.run_path(str(ROOT / "tools" / "glossary"))


def test_words_in_prose_and_identifiers() -> None:
    """In a comment over two lines and in a part of a name; a word inside another word does not count."""
    text = '"""Force held\nagainst the law; besides."""\nkept_force = 1  # what stands here\nskeptic = KEPT_FORCE = kept_force\n'
    prose, names = GLOSSARY["of_python"](text)
    assert prose["held against"] == 1 and prose["stands"] == 1 and prose["beside"] == 0
    assert names == {"kept": 3}


def test_no_word_has_become_more() -> None:
    """Against tools/glossary.csv, as `make lint` does."""
    now, stored = GLOSSARY["count"](), GLOSSARY["stored"]()
    assert {key: n for key, n in now.items() if n > stored.get(key, 0)} == {}
