"""How accurate is each law compared with the exact bridge, and what does a call cost? `pywet study laws`, without a run."""
