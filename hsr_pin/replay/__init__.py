"""Animations and plots of simulated and measured motion.

- ``animation``: arms, markers, trails and gaps in meshcat
- ``bodies``: visuals of the URDF in motion
- ``drawn``: Drawn: a run as input of every picture
- ``labels``: text in the scene
- ``live``: animation in the browser
- ``obstacles``: obstacles and their forces
- ``page``: animation as a self-contained HTML file
- ``plots``: figures of tip paths and errors
- ``viewer``: meshcat, imported without its warnings
"""
