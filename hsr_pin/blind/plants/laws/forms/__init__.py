"""Laws of the catalogue in forms that the catalogue does not have, at least two of each.

- ``actuation``: lags, delays, biases and maps of the torque
- ``damping``: creep and damping
- ``elastic``: stiffness along the arm and over bending, stops, play
- ``friction``: friction and hysteresis
- ``mounting``: mounts, masses, markers
- ``scale``: quantity with which the size of a law scales
"""
