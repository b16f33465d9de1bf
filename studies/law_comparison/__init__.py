"""How far is each law from the exact bridge, and what does a call cost? Laws alone, without a run. `pywet study laws`."""
