"""From recordings to numbers of the arm, with honest uncertainty.

- ``arm_document``: the arm behind a fit as JSON
- ``choice``: names of what is open -> a hypothesis
- ``command``: what a trial's input commands, section by section
- ``comparison``: compare: simulation beside measurement
- ``document``: a fit as JSON
- ``evaluation``: what a hypothesis predicts, and its residuals
- ``experiment``: a dataset made ready to be compared
- ``figure``: a fit as a picture
- ``fit``: bounded, robust least squares
- ``fitted_arms``: the arm with fitted numbers
- ``heldout``: leave one trial out
- ``hypothesis``: Hypothesis: a model with open parameters
- ``identify``: identify: the whole fit of a dataset
- ``input_form``: what a command does between its samples, where nobody says
- ``links_study``: how many links are worth their cost
- ``misfit``: weighted residuals and derivatives for the search
- ``nuisance``: what belongs to a trial and not to the arm
- ``paper_procedure``: the paper's own five steps and its grid over C
- ``phases``: rest, command change, transient, settled
- ``pose``: how an arm is bent whose markers are seen
- ``profile``: profile likelihood
- ``reach``: how far from the base a marker may be
- ``release``: how a motion starts that does not start at rest
- ``starts``: several starts of a search
- ``step``: one damped Gauss-Newton step
- ``uncertainty``: intervals, correlations, what the data cannot tell
"""
