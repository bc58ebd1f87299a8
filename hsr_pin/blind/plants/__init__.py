"""Independent plants: arms simulated by other engines, with laws written afresh.

- ``arm``: what is simulated, in its own frame
- ``chain``: ChainPlant, a fine chain in MuJoCo
- ``laws``: the nineteen effects of the catalogue, other forms of them, and laws outside of it
- ``march``: what comes before and the time loop, which all engines share
- ``mess``: what goes wrong where hardware is recorded
- ``nuisance``: what is always a little wrong
- ``others``: plants by other authors, each with its own physics and laws
- ``plant``: Plant.run: a program and effects in, a folder of recordings out
- ``program``: steps, staircase, chirp, releases, payload
- ``rod``: RodPlant, a Cosserat rod in PyElastica
- ``scaling``: give an effect the strength that a marker gap asks for
- ``space``: the same for arms in space: BallPlant, SpaceRodPlant, and laws about two axes
- ``writing``: markers and files

Nothing here imports any other part of hsr_pin but its errors, and no engine is imported before it runs.
"""
