"""The exact capillary bridge, solved a second way."""
