"""Parts in contact with rollers or rings, and their supports: races, cage, flanges, shaft, mounts."""
