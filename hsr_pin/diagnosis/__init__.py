"""Where the gap lies, which effect causes it, how far it shrinks.

- ``base_motion``: whether the base moves, and what follows from that
- ``change``: what has changed between two recordings
- ``commands``: plateaus and steps of a command
- ``diagnose``: diagnose: dataset -> Diagnosis
- ``document``: a diagnosis as JSON
- ``figures``: the pictures of the report
- ``fingerprint``: what recordings show without a model
- ``next_experiment``: what to record next
- ``pulsation``: what pulses by a clock of its own
- ``repeats``: trial-to-trial repeatability
- ``report``: a diagnosis as one HTML page
- ``residual_torque``: the torque along the arm that the model lacks
- ``result``: what a diagnosis found, and how it is shown in Python
- ``smooth``: motion smoothed and differentiated; ranks
- ``verdict``: the words of a verdict on an arm
- ``where``: maps along the arm, time, operating range and trials
- ``words``: names and numbers as a person would say them
"""
