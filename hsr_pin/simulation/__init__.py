"""Scenarios in, trajectories out: one arm or a thousand side by side.

- ``batch``: simulate_batch: groups scenarios by shape and runs each group
- ``cameras``: what is seen of the markers
- ``columns``: springs, dampers, effects and drives of many arms as arrays
- ``drive``: commands over time: steps of torque or pressure, files
- ``forward``: accelerations by ABA or RNEA
- ``integrators``: one file per method
- ``inverse``: which torque, which pressures, make a motion
- ``measures``: settled tip, settling time, overshoot, distance from a circle
- ``result``: SimulationResult and its outcomes
- ``scenario``: Scenario: what to simulate
- ``sensitivity``: derivatives of marker positions to parameters
- ``simulate``: simulate: a batch of one
- ``statics``: the pose at which an arm rests
- ``stepper``: one step, state in and out
"""
