"""An explorer of designs in the browser: sliders, the shape, its numbers, the front, exports.

``space`` says what can be varied, ``wanted`` what one tab asks for, ``library`` keeps solutions and
interpolates between them, ``describe`` makes what a tab shows, ``solve`` is what the worker runs,
``rig`` writes the set-up of a measurement, ``session`` answers tabs, ``server`` lets them in.
"""
