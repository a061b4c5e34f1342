"""dolfingrip: simulation, design and diagnosis of pneumatic soft-gripper fingers."""

__version__ = "0.1.0"
