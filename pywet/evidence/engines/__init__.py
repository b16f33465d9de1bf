"""The same scene in other engines and stock models, and how far their results are from each other."""
