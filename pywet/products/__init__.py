"""What a plant asks of a screen: feed, outlets, partition curve, efficiency, throughput and moisture of the products."""
