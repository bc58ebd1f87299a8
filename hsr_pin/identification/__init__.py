"""From recordings to numbers of the arm, with honest uncertainty.

- ``choice``: names of what is open -> a hypothesis
- ``comparison``: compare: simulation beside measurement
- ``document``: a fit as JSON
- ``evaluation``: what a hypothesis predicts, and its residuals
- ``experiment``: a dataset made ready to be compared
- ``figure``: a fit as a picture
- ``fit``: bounded, robust least squares, corrected for the coarse chain
- ``fitted_arms``: the arm with fitted numbers
- ``heldout``: leave one trial out
- ``hypothesis``: Hypothesis: a model with open parameters
- ``identify``: identify: the whole fit of a dataset
- ``links_study``: how many links are worth their cost
- ``misfit``: weighted residuals and derivatives for the search
- ``paper_procedure``: the paper's own five steps and its grid over C
- ``phases``: rest, command change, transient, settled
- ``profile``: profile likelihood
- ``release``: how a motion starts that does not start at rest
- ``starts``: several starts of a search
- ``uncertainty``: intervals, correlations, what the data cannot tell
"""
