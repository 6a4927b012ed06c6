"""From the lowest to the highest of the velocity."""


def span(case, time, series):
    velocity = series["ring.velocity.x"]
    return velocity.max() - velocity.min()


def per_depth(case, time, series):
    depth = case.defects[0].depth if case.defects else 0.0
    return span(case, time, series) / depth if depth else float("inf")
