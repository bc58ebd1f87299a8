"""Simulation of arms that bend in space: the loops of planar arms, with joints of three coordinates.

The coordinates of a joint are (towards x, towards y, twist) in the frame that it is attached to: a rotation vector, on whose
components springs and dampers act. The N joints of an arm form rows of 3 N numbers. A bending law gets the first two coordinates
as one complex number.

- ``account``: the energies of a motion
- ``drive``: two components of torque, and loads, over time
- ``elements``: one joint: its rotation, its axes and their rates
- ``equilibrium``: the equilibrium pose of an arm under a constant torque and loads
- ``kernel``: the inner loops, for the compiler
- ``loops``: the loops as machine code
- ``reference``: the dynamics that the loops need, by Pinocchio
- ``system``: bodies, springs, dampers and loads of many arms as arrays
"""
