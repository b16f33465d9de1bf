"""Where a run stays finite, keeps its ledger and makes no energy: maps, hard scenes, and a campaign of hard cases."""
