"""A report as one HTML page: results in 3D, curves, a front, checks, where all of it comes from.

``sources`` finds results in folders, ``runs`` reads an experiment's; ``shapes`` and ``grasp`` make
3D scenes of it, ``curves`` charts, ``key_numbers`` and ``trust`` what a reader asks first;
``diagnosis`` reads a diagnosis, ``front`` a design loop. ``build`` puts them together and
``html`` writes the page. ``web/`` has the JavaScript.
"""
