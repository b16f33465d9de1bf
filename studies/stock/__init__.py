"""The bridge laws that stock programs ship, measured from their binaries as they are: two bodies, one gap, one force."""
