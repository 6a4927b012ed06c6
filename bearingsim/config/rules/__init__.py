"""Rules of a case: abilities asked of the model, contradictions, slices."""
