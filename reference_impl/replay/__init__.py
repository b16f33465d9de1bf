"""Replay of a run: logs read in parts, liquid ledger, recomputed forces, comparisons."""
