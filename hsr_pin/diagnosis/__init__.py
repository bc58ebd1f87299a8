"""Where the gap lies, which effect causes it, how far it shrinks.

- ``base_motion``: whether the base moves, and what follows from that
- ``candidate``: a fitted model, and what the judgement needs to know of it
- ``change``: what has changed between two recordings
- ``commands``: plateaus and steps of a command
- ``diagnose``: diagnose: dataset -> Diagnosis
- ``document``: a diagnosis as JSON
- ``estimates``: values and intervals as they are shown
- ``figures``: the pictures of the report
- ``fingerprint``: what recordings show without a model
- ``fit_pool``: proposals, quick fits and full fits of many models side by side
- ``inline_svg``: pictures inside a page
- ``ladder``: how far, rung by rung
- ``next_experiment``: what to record next
- ``page``: in what surroundings pages are written
- ``proposals``: what may be added to a model, where its fit would start, and how much it promises
- ``pulsation``: what pulses by a clock of its own
- ``repeats``: trial-to-trial repeatability
- ``report``: a diagnosis as one HTML page
- ``resampling``: errors on held-out trials, with intervals from trials drawn anew
- ``residual_torque``: the torque along the arm that the model lacks
- ``result``: what a diagnosis found, and how it is shown in Python
- ``screening``: which proposals get a quick fit
- ``search``: which models are fitted, until none could be credible any more
- ``smooth``: motion smoothed and differentiated; ranks
- ``verdict``: what is reported of the posterior, in words
- ``where``: maps along the arm, time, operating range and trials
- ``words``: names and numbers as a person would say them
"""
