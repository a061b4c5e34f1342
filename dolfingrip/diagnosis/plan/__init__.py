"""What a rig could find out, before anything is measured."""
