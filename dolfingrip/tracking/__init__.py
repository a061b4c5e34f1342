"""Videos and pictures to measured data: frames, points, plane, body coordinates, clock, table."""
