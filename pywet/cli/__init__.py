"""The command line: commands, what they print, what is installed."""
