"""Laws of contact and friction: scalar functions of approach, rate and slip.

Three packages: ``stiffness`` (the elastic force), ``damping`` (the normal force around it), ``friction``. In each,
``interface.py`` declares the functions of every law. A law is one module with its constants as a ``NamedTuple``
and its functions, each next to its derivatives. No module lists the laws, so a law can be in any package.
"""
