"""What a case may ask for: which model can do it, what contradicts, where slices end."""
