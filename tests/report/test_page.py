"""The frame of the pages: everything asked for is in it, and text cannot break it."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from pywet.report import page


def test_page_holds_what_it_was_given(tmp_path: Path) -> None:
    """Cards, sections with anchors, a table with colours and links, a picture inside the file; text is escaped."""
    figure, axes = plt.subplots()
    axes.plot([0, 1], [0, 1])
    rows = [["a < b", page.Cell("1e-9", "good", "worst of 3", "runs/x")], ["c", page.Cell("?", "none")]]
    body = page.paragraph("Take `this` & that.") + page.table(["what", "value"], rows) + page.picture(figure, "a line")
    path = page.write(
        tmp_path / "p.html",
        "Title",
        "Lead <i>",
        [page.Section("One thing", body, "One")],
        [page.Card("3", "of 4", "bad")],
    )
    plt.close(figure)
    text = path.read_text()
    assert '<section id="one">' in text and 'href="#one"' in text
    assert "<code>this</code> &amp; that" in text and "a &lt; b" in text and "Lead &lt;i&gt;" in text
    assert '<td class="good" title="worst of 3"><a href="runs/x">1e-9</a></td>' in text
    assert 'src="data:image/svg+xml;base64,' in text and 'class="card bad"' in text
