"""What recordings show without a model: one print a file.

- ``bending``: how far the arm is bent, as one number
- ``creep``: slow drift after the transient
- ``decay``: frequency and damping over amplitude
- ``fingerprint``: fingerprint: Experiment -> Fingerprint
- ``length``: length of the backbone over bending
- ``lines``: of arms in space, the trials that stay on a line
- ``loops``: loops of bending over the command
- ``out_of_plane``: motion out of the plane
- ``prints``: what a print is; numbers with intervals
- ``rests``: scatter and direction of rest poses
- ``sides``: of arms in space, frequency by the side
- ``start``: how long a hand or a slack load still acts
- ``timing``: times of rise and fall
"""
