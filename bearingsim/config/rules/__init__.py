"""Rules of a case: required abilities of the model, completion, conflicts."""
