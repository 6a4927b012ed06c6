"""Parts that touch or hold the rollers and rings: races, cage, flanges, shaft, mounts."""
