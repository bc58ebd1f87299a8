"""Where the gap lies, which effect causes it, how far it shrinks.

- ``base_motion``: whether the base moves, and what follows from that
- ``candidates``: where the fit of each effect starts, and what it is worth
- ``change``: what has changed between two recordings
- ``commands``: plateaus and steps of a command
- ``confidence``: how likely a name is right
- ``crew``: many candidates side by side
- ``diagnose``: diagnose: dataset -> Diagnosis
- ``document``: a diagnosis as JSON
- ``estimates``: values and intervals as they are shown
- ``evidence``: resampling of trials; what lasts beyond noise
- ``figures``: the pictures of the report
- ``fingerprint``: what recordings show without a model
- ``inline_svg``: pictures inside a page
- ``ladder``: how far, rung by rung
- ``next_experiment``: what to record next
- ``page``: in what surroundings pages are written
- ``pulsation``: what pulses by a clock of its own
- ``repeats``: how far the arm is from itself
- ``report``: a diagnosis as one HTML page
- ``residual_torque``: the torque along the arm that the model lacks
- ``search``: effects added one at a time, several sets side by side
- ``smooth``: motion smoothed and differentiated; ranks
- ``spread``: how what is missing is spread along the arm
- ``support``: what speaks for each part and kind
- ``verdict``: what may be said
- ``where``: maps along the arm, time, operating range and trials
- ``words``: names and numbers as a person would say them
"""
