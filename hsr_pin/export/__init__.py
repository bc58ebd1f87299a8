"""Export of the model to MuJoCo, URDF and SDF.

- ``bodies``: links, joints and markers for all formats
- ``document``: reading of a fit or a diagnosis from its JSON
- ``elements``: MuJoCo elements that represent effects
- ``file``: Exported: texts of an export, and lists of what they contain and lack
- ``law_text``: source text of the laws of an effect
- ``mjcf``: export to MuJoCo
- ``model``: CorrectedModel: the model that is exported
- ``parts``: assignment of effects to MuJoCo elements and a Python module
- ``plain``: description of effects that URDF and SDF cannot express
- ``schema``: validation of a result that is read again
- ``sdf``: export to SDF for Gazebo and Drake
- ``solids``: obstacles as solids of the formats
- ``templating``: text from a template
- ``timestep``: largest time step in MuJoCo
- ``urdf``: export to URDF for other programs
"""
