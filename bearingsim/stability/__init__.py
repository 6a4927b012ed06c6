"""Where each method fails: a matrix of materials and steps, each run judged."""
