"""Diagnosis of the sim-to-real gap: where it lies, which effects cause it, and how much each effect explains.

- ``base_motion``: the part of the gap that the motion of the base predicts
- ``change``: changes between two recordings
- ``commands``: plateaus and steps of a command
- ``diagnose``: the function ``diagnose``
- ``document``: a diagnosis as JSON
- ``figures``: the figures of the report
- ``indicators``: model-free indicators of the recordings
- ``next_experiment``: the most informative next experiment
- ``pulsation``: periodic disturbances that do not follow the command
- ``repeatability``: trial-to-trial repeatability
- ``report``: a diagnosis as one HTML page
- ``residual_torque``: the torque along the arm that the model lacks
- ``result``: the diagnosis and its display in Python
- ``smooth``: smoothing, differentiation and rank correlation
- ``verdict``: the vocabulary of a verdict on an arm
- ``where``: maps of the gap along the arm, time, operating range and trials
- ``words``: sentences for the report and the screen
"""
