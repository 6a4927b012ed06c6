"""Text input and output: quantities with units, YAML with positions, formulas, terminal."""
