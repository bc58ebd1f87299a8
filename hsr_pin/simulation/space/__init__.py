"""An arm that bends in space: the same loops as in the plane, with joints of three coordinates.

A joint's coordinates are (towards x, towards y, twist) of the frame that it hangs on: a rotation vector, on whose components
springs and dampers act. An arm's N joints stand in rows of 3 N numbers. A bending law sees the first two as one complex number.

- ``account``: the energies of a motion
- ``drive``: two components of torque, and loads, over time
- ``elements``: one joint: its rotation, its axes and their rates
- ``kernel``: the inner loops, for the compiler
- ``loops``: them as machine code
- ``reference``: what the loops ask of the arms, by Pinocchio
- ``rest``: the pose at which an arm rests
- ``system``: bodies, springs, dampers and loads of many arms as arrays
"""
