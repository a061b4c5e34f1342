"""A blind benchmark of the diagnosis: hidden causes by a generator that is not the analyser.

From the bottom up:

- :mod:`protocols`: what is measured, row by row;
- :mod:`noise`: instruments' noise with a part that drifts, and readings that are missing;
- :mod:`generator`: the finger as the generator simulates it, and the causes that it can hide;
- :mod:`outsiders`: causes that no catalogue has;
- :mod:`library`: the generator's responses, simulated once and kept;
- :mod:`response`: readings at any strength and with any nuisances from the library;
- :mod:`cases`: what is hidden in each case, and its files;
- :mod:`full`: cases with a simulation of their own;
- :mod:`bound`: what exact evidence says of a case;
- :mod:`diagnoses`: what the analyser says of it;
- :mod:`score`: figures and their bounds;
- :mod:`outcomes`: judged cases as a table;
- :mod:`report`: figures as tables and pictures.

``scripts/blind-benchmark --help`` tells the stages.
"""
