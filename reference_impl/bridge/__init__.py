"""The exact capillary bridge, solved by a second method."""
