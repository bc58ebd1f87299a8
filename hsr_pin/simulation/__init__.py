"""Simulation of arms: a scenario in, a trajectory out, for one arm or for many arms in parallel.

- ``actuators``: the actuator response to a command that arrives step by step
- ``arm_batch``: bodies, springs, dampers and effect laws of many arms as arrays
- ``batch``: simulate_batch: many scenarios at once
- ``cameras``: marker positions as the cameras measure them
- ``code_cache``: the cache of machine code, tolerant of damaged files and a full disk
- ``command``: the torque that arrives at the arms for a known command
- ``compiled``: the loops as machine code
- ``drive``: commands over time: steps of torque or pressure, and commands from files
- ``energy``: the energy balance of a motion
- ``equilibrium``: the equilibrium pose of an arm under a constant torque
- ``integrate``: the loop over time, for Python and for the compiler
- ``integrator``: the integration methods and the choice of step lengths
- ``inverse``: inverse dynamics: the torque or the pressures that produce a motion
- ``kernel``: the inner loops, for the compiler
- ``laws``: the laws of effects as machine code
- ``load``: a force and a moment on a point of an arm in space
- ``marker_projection``: marker positions of planar arms, for the compiler
- ``measures``: settled tip position, settling time, overshoot, distance of the tip path from a circle
- ``motion``: the motion of a batch from its start to its last sample
- ``reference``: the dynamics that the loops need, by Pinocchio
- ``result``: SimulationResult and its outcomes
- ``scenario``: Scenario: the input of a simulation
- ``sensitivity``: derivatives of marker positions with respect to parameters
- ``simulate``: simulate: one scenario
- ``source_hash``: a hash of the source code that machine code was compiled from
- ``space``: the loops for arms that bend about two axes
- ``warm``: initialisation of numba for processes from which workers are forked
"""
