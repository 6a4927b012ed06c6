"""The ladder of models. A model is a module with a ``NamedTuple`` of parameters and the same few functions.

``accelerations(model, t, y)``   forces and accelerations from the positions and velocities in the buffer
``stability(model, y, j)``       stiffness/mass and damping/mass of body j as it stands, for the live step limit
``width(model)``                 how much of a row the model uses

``static`` has no accelerations: ``rest(model, t, y)`` puts the ring where the forces balance.
"""
