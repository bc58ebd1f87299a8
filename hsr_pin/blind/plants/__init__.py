"""Independent plants: simulated arms in other engines, with laws that were written separately from the model.

- ``arm``: the simulated arm and its frame
- ``artefacts``: recording artefacts of real hardware
- ``chain``: ChainPlant, a fine chain in MuJoCo
- ``integration``: settling and time loop, which all engines share
- ``laws``: the nineteen effects of the catalogue, other forms of them, and laws outside of it
- ``nuisance``: small errors that every recording has
- ``others``: plants by other authors, each with its own physics and laws
- ``plant``: Plant.run, which records a program with effects into a folder
- ``program``: steps, staircase, chirp, releases, payload
- ``rod``: RodPlant, a Cosserat rod in PyElastica
- ``scaling``: scaling of an effect to a marker gap
- ``space``: BallPlant, SpaceRodPlant, and laws for bending about two axes
- ``writing``: markers and files

Nothing here imports any other part of hsr_pin except its errors, and no engine is imported before it runs.
"""
