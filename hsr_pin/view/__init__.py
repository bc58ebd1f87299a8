"""Interactive page that shows recordings beside the model, with sliders for the model's parameters and effects.

- ``controls``: sliders and their ranges
- ``page``: Page: the page, built with viser
- ``scene``: the arm in three dimensions
- ``served``: viser's server, restricted to pages of this machine
- ``session``: Session: recordings and the model, simulated again for every setting
- ``settings``: Settings: values of the sliders
"""
