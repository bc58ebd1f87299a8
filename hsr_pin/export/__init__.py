"""Handing the model on: to MuJoCo, and as URDF and SDF to everyone else.

- ``bodies``: links, joints and markers, as every target needs them
- ``document``: a fit or a diagnosis, read from its JSON
- ``elements``: which MuJoCo elements stand for which effect
- ``file``: Exported: texts, what they hold and what they do not
- ``law_text``: an effect's laws as a text of their own
- ``mjcf``: to MuJoCo
- ``model``: CorrectedModel: what is handed on
- ``parts``: the effects, sorted by what becomes of them in MuJoCo
- ``plain``: what URDF and SDF cannot say, in words
- ``schema``: what a result must be to be read again
- ``sdf``: to Gazebo and Drake
- ``templating``: text from a template
- ``timestep``: how long a step of MuJoCo may be
- ``urdf``: to everything else
"""
