"""From the lowest to the highest of the velocity."""


def span(case, time, series):
    velocity = series["ring.velocity.x"]
    return velocity.max() - velocity.min()
