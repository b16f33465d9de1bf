"""Tests of what lies under benchmarks/."""
