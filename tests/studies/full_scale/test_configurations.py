"""Copies of a configuration folder with other settings."""

from pathlib import Path

from pywet import config as settings
from studies.full_scale.campaign import write_again
from tests.error_codes import raises_code

SOURCE = Path(__file__).parents[3] / "config"


def test_a_folder_with_a_file_of_the_user_is_refused_as_it_is(tmp_path: Path) -> None:
    """Expect that a refused folder has lost nothing; a folder of copies alone is written again."""
    write_again(SOURCE, tmp_path / "made", "smoke", {})
    write_again(SOURCE, tmp_path / "made", "smoke", {})
    (tmp_path / "made" / "notes.txt").write_text("mine")
    with raises_code("cost.folder"):
        write_again(SOURCE, tmp_path / "made", "smoke", {})
    assert {path.name for path in (tmp_path / "made").iterdir()} == {*settings.FILES, "notes.txt"}
