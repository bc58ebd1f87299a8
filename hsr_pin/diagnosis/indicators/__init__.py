"""Model-free indicators: what recordings show without a model, one indicator in each file.

- ``bending``: the bending angle of the whole arm
- ``creep``: slow drift after the transient
- ``decay``: frequency and damping as functions of the amplitude
- ``indicator``: the base class of an indicator, and the formatting of numbers
- ``indicators``: all indicators of an experiment
- ``length``: length of the backbone as a function of bending
- ``lines``: trials of an arm in space that stay on one line
- ``loops``: hysteresis loops of bending over the command
- ``out_of_plane``: motion out of the plane
- ``rests``: scatter and direction of equilibrium poses
- ``sides``: frequency of an arm in space as a function of the direction
- ``start``: disturbance by a hand or a slack load after a release
- ``timing``: rise and fall times
"""
