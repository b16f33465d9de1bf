"""Evidence about pywet: accuracy, stability and effects studied, agreement with other engines, laws and measurements, full scale."""
