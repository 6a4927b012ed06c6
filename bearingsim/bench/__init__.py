"""Speed against accuracy: error and cost of models, methods, steps and tolerances in some scenes."""
