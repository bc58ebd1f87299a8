"""Simulation and measurement to look at.

- ``animation``: arms, markers, trails and gaps in meshcat
- ``bodies``: the visuals of the URDF in motion
- ``drawn``: Drawn: what every picture takes
- ``labels``: text in the scene
- ``live``: in the browser, live
- ``page``: as one self-contained HTML file
- ``plots``: tip paths and errors, for print
- ``viewer``: meshcat, imported without its warnings
"""
