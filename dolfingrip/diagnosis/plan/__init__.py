"""A plan of what a rig could find out, before anything is measured."""
