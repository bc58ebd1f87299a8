"""Arms in space: extensions of the planar plants; moments and torques are complex numbers, x + i y.

- ``arm``: the arm's frame in the world, nodes and motions in space
- ``chain``: BallPlant, a fine chain of ball joints in MuJoCo
- ``laws``: laws that exist in space only, and laws that need another form for two axes
- ``plant``: SpacePlant, the base class of both plants
- ``program``: steps, circles and chirps in all directions, releases, payload
- ``rod``: SpaceRodPlant, a Cosserat rod in PyElastica
- ``writing``: markers at a distance from the backbone
"""
