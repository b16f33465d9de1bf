"""Evidence about pywet: accuracy, stability, effects; agreement with other engines and with measurement; full scale."""
