"""Speed against accuracy: models, methods, steps and tolerances in some scenes, each with its error and price."""
