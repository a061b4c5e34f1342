"""Numbers of a design by their names: of its shape, of readings at a place, of a grasp."""
