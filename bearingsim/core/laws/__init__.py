"""Laws of contact and friction: scalar functions of approach, rate and slip.

Three packages: ``stiffness`` (the elastic force), ``damping`` (the normal force around it), ``friction``. In each
``interface.py`` declares what every law gives. A law is one module: its constants as a ``NamedTuple``, then
its functions, each beside its derivatives. No module lists the laws, so one of your own may lie anywhere.
"""
