"""Scenarios in, trajectories out: one arm or a thousand side by side.

- ``batch``: simulate_batch
- ``cameras``: what is seen of the markers
- ``code_cache``: where machine code is kept, and what becomes of a damaged or a full cache
- ``columns``: bodies, springs, dampers and laws of many arms as arrays
- ``command``: what arrives of a command: held or interpolated, then what the muscles make of it
- ``compiled``: the loops as machine code
- ``drive``: commands over time: steps of torque or pressure, files
- ``energy``: the energy account of a motion
- ``integrator``: the methods, and how steps are chosen
- ``inverse``: which torque, which pressures, make a motion
- ``kernel``: the inner loops, for the compiler
- ``laws``: the effects' laws as machine code
- ``load``: a force and a moment on a point of an arm in space
- ``march``: the loop over time, for Python and for the compiler
- ``measures``: settled tip, settling time, overshoot, distance from a circle
- ``motion``: columns from their start to their last sample
- ``muscles``: a command through the muscles, step by step
- ``reference``: what the loops ask of the arms, by Pinocchio
- ``rest``: the pose at which an arm rests
- ``result``: SimulationResult and its outcomes
- ``scenario``: Scenario: what to simulate
- ``sensitivity``: derivatives of marker positions to parameters
- ``sight``: where markers are, for the compiler
- ``simulate``: simulate: a batch of one
- ``space``: the loops for arms that bend about two axes
- ``stamp``: a mark of the source that compiled code was made from
- ``warm``: what numba sets up first, for processes that others are forked from
"""
