"""Which surface tension, friction, film … reproduce what was measured, and how well that is known: `pywet calibrate`."""
