"""Rules of a case: abilities that it needs of the model, default values that depend on others, conflicts."""
