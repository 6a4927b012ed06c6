"""Places and motion of bodies."""
