"""The arm: numbers -> URDF text -> Pinocchio model; what its pressures do.

- ``appearance``: how the arm is drawn
- ``chain``: the rigid bodies of many planar arms as arrays
- ``combinations``: Table II of the paper
- ``kinematics``: where the points of the backbone are, for many poses at once
- ``links``: the cylinders and hinges of a URDF
- ``model``: build_model: specification -> pin.Model
- ``pressure``: PressureMap: pressures, stiffness, bending and torque, Eqs. (1), (4), (5)
- ``rotations``: rotation vectors of many joints at once
- ``scatter``: how far the 16 measured rows are from the planes through them
- ``sections``: stretches of an arm with inputs of their own
- ``space``: the base, the bodies and the Pinocchio model of an arm in space
- ``space_kinematics``: where the points of an arm in space are
- ``specification``: ArmSpecification: Table I and what the paper leaves open
- ``urdf``: arm_to_urdf, load_urdf, save_urdf
- ``xml_tree``: XML with line and column of every element
"""
