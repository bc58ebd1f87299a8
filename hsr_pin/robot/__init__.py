"""The arm: specification -> URDF text -> Pinocchio model, and the map from pressures to torque.

- ``appearance``: how the arm is drawn
- ``chain``: the rigid bodies of many planar arms as arrays
- ``combinations``: Table II of the paper
- ``kinematics``: positions of points on the backbone for many poses at once
- ``links``: the cylinders and hinges of a URDF
- ``model``: build_model: specification -> pin.Model
- ``pressure``: PressureMap: pressures, stiffness, bending and torque, Eqs. (1), (4), (5)
- ``rotations``: rotation vectors of many joints at once
- ``scatter``: scatter of the 16 measured rows about their regression planes
- ``sections``: sections of an arm with separate inputs
- ``space``: the base, the bodies and the Pinocchio model of an arm in space
- ``space_kinematics``: positions of points on an arm in space
- ``specification``: ArmSpecification: Table I of the paper, and further properties
- ``urdf``: arm_to_urdf, load_urdf, save_urdf
- ``xml_tree``: XML with line and column of every element
"""
