"""The model in the hands of a controller.

chambers, pressures for the torques of sections; controllers, the laws; dynamics, M, C, G and the linearisation; environment and
registration, for Gymnasium; latency, of a step; observer, the state from markers; reach, the tip at rest; reference, what to
follow; regulators, pressures for a torque; stepping, the arm itself. ``examples/`` shows them at work.
"""
