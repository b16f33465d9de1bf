"""Accuracy of the numbers of a short run of a deck: seeds, duration of the feed, contact stiffness, time step."""
