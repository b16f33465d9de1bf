"""The former name of the module of custom laws."""

from __future__ import annotations

import pytest

from pywet.laws import custom_laws


def test_the_former_name_warns_and_gives_the_same() -> None:
    from pywet.laws import own

    with pytest.warns(DeprecationWarning, match=r"pywet\.laws\.own is now pywet\.laws\.custom_laws"):
        assert own.trust is custom_laws.trust
