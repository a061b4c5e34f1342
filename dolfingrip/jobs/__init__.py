"""Many simulations: each a job by its key, computed by workers, its answer kept in a folder.

Whoever is killed loses nothing that was finished, and the next call computes only what is missing.
"""
