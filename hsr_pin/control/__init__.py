"""Control of simulated arms: models, controllers, an observer, references, and reinforcement-learning environments.

- ``bodies``: the rigid-body dynamics of an arm
- ``chambers``: pressures for the torques of sections
- ``controllers``: feedback laws
- ``dynamics``: M, C, G and the linearisation
- ``environment``: environments for Gymnasium
- ``fleet``: many arms that are advanced in one call
- ``latency``: the computing time of a step
- ``observer``: the state from marker positions
- ``reach``: equilibrium poses and their tip positions
- ``reference``: motions to follow
- ``registration``: registration of the environments in Gymnasium
- ``regulators``: pressures for a torque
- ``stepping``: one arm, advanced step by step
- ``task``: the tasks of the environments
- ``vector``: many environments as one

``examples/`` contains complete programs.
"""
