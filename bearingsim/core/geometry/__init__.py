"""Where bodies stand and how they move."""
