"""Words and marks of a file: quantities with units, YAML with positions."""
