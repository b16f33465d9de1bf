"""The moist batch screening of Elskamp & Kruggel-Emden (2018): cases, fraction retained, where the liquid is."""
