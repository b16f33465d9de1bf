"""A long continuous run, in one piece and killed twice: same bits, ledger, replay and memory, for docs/screens.md."""
