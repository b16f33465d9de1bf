"""Calibrate surface tension, friction, film thickness … to measurements, with confidence intervals: `pywet calibrate`."""
