"""Speed, accuracy and memory of dolfingrip, and of its peers on the same meshes.

``scripts/benchmark`` runs this. Each run is a process of its own (:mod:`benchmarks.job`), what it
yields is kept in ``benchmarks/outcomes``, and ``benchmarks/results.md`` is written from there.
"""
