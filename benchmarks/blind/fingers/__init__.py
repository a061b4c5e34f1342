"""Fingers that are simulated by other elements, barriers and load steps than the analyser's.

    scripts/run python -m benchmarks.blind.fingers run --set development   # mended on these
    scripts/run python -m benchmarks.blind.fingers run --set confirmation  # final figures only
    scripts/run python -m benchmarks.blind.fingers score

Every case is simulated on its own, with all causes and nuisances at once (``finger.py``), and
written as CSV and TOML as a laboratory would. ``dolfingrip diagnose`` reads these with its default
settings, the whole catalogue, and a store of simulations that the cases of a protocol share.
"""
