"""Changes between two recordings of one arm: the current recording compared with the reference recording.

- ``chance``: apparent changes between trials of the reference recording
- ``diagnose``: the function ``diagnose_change``
- ``discrepancy``: statistical model of the model discrepancy in the reference recording
- ``document``: a change as JSON
- ``figures``: the figures of the report
- ``fitting``: initial estimates and fits of change hypotheses
- ``frame``: whitened residuals of both recordings
- ``history``: several recordings in order
- ``hypotheses``: change hypotheses: parameters or effects that may have changed
- ``mounting``: changes of the base and of the cameras as effects
- ``pair``: two recordings as one experiment
- ``reference``: the best model of the reference recording
- ``report``: a change as one HTML page
- ``size``: the size of a change and its interval
- ``swing``: apparent damping changes that follow from a change of frequency
- ``verdict``: the verdict on a change
- ``words``: sentences on a change
"""
