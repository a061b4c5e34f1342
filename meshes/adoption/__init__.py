"""A user's own geometry: what is cavity, clamp and tip, and its mesh in the finger's frame."""
