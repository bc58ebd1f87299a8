"""Laws of the catalogue in forms that are not the catalogue's own, two or more of each.

- ``actuation``: lags, delays, biases and maps of the torque
- ``damping``: creep and damping
- ``elastic``: stiffness along the arm and over bending, stops, play
- ``friction``: friction and hysteresis
- ``mounting``: mounts, masses, markers
- ``scale``: what a size goes with
"""
