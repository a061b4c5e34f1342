"""Effects that the simple model leaves out, one in each file; the configuration switches them on.

``[extensions.prony] g = [0.2] tau_s = [10]`` in the configuration is enough.
:mod:`dolfingrip.extensions.effect` explains the hooks by which an effect takes part, and
:mod:`dolfingrip.extensions.index` lists all effects.
"""
