"""What touches and holds the rollers: races, cage, flanges, shaft, mounts."""
