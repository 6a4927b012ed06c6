"""A package that is not bearingsim's: one toy of each kind, a file and a line each."""

from bearingsim.catalogue import Feature, Law, Method, Model, Shape, register

register(Law("quadratic", "stiffness", "toy_bearing.quadratic:Section", "toy_bearing.quadratic:build"))
register(Law("viscous", "damping", "toy_bearing.viscous:Section", "toy_bearing.viscous:build", bare=True))
register(Law("unfinished", "damping", "toy_bearing.unfinished:Section", "toy_bearing.unfinished:build", bare=True))
register(Method("leapfrog", "toy_bearing.leapfrog"))
register(Model("one-mass", "toy_bearing.one_mass", frozenset({"balance", "shapes", "acceleration"})))
register(Shape("wedge", "toy_bearing.wedge:Wedge"))
register(Feature("velocity.span", "m/s", "span of the velocity", "toy_bearing.span:span"))
register(Feature("velocity.per_depth", "1/s", "the same over the pit's depth", "toy_bearing.span:per_depth"))
