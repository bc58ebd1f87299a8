"""Arms in space: what is another for them than in the plane; their moments and torques are complex numbers, x + i y.

- ``arm``: the arm's frame in the world, nodes and motions in space
- ``chain``: BallPlant, a fine chain of ball joints in MuJoCo
- ``laws``: laws of space alone, and the forms about two axes of those that need one
- ``program``: steps, circles and chirps to all sides, releases, payload
- ``rod``: SpaceRodPlant, a Cosserat rod in PyElastica
- ``writing``: markers beside the backbone
"""
