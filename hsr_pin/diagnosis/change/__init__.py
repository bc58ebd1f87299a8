"""What has changed between two recordings of one arm: NEW judged relative to OLD.

- ``chance``: what OLD's own trials would show
- ``diagnose``: diagnose_change: two datasets -> ChangeDiagnosis
- ``document``: a change as JSON
- ``figures``: the pictures of the report
- ``fitting``: how much of the difference a change explains
- ``frame``: residuals free of what is expected of them
- ``history``: several recordings, in order
- ``leftover``: what the model of OLD lacks and has no name for
- ``pair``: two recordings as one experiment
- ``placing``: how the arm and its cameras stand may be another
- ``reference``: the best model of OLD
- ``report``: a change as one HTML page
- ``size``: how large a change is, and how sure that is
- ``suspects``: what may have changed
- ``swing``: what damping may do by itself where a change makes an arm swing slower or faster
- ``verdict``: what may be said
- ``words``: a change as a person would say it
"""
