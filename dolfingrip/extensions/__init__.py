"""What the simple model leaves out: one effect a file, each switched on from the config.

``[extensions.prony] g = [0.2] tau_s = [10]`` in the configuration is enough; see
:mod:`dolfingrip.extensions.effect` for the hooks by which an effect takes part and
:mod:`dolfingrip.extensions.index` for the effects there are.
"""
