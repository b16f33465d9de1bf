"""Evaluation of screens: feed, outlets, partition curve, efficiency, throughput and moisture of the products."""
