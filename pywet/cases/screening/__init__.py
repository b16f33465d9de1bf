"""The moist batch screening of Elskamp & Kruggel-Emden (2018): cases, fraction retained, distribution of liquid."""
