"""A page to look and try: recordings, the model beside them, and a slider for everything that it may be or lack.

- ``controls``: sliders: what can be set, and how far
- ``page``: Page: what is seen, on viser
- ``report``: the report of a diagnosis, for the page to link to
- ``scene``: the arm in three dimensions
- ``session``: Session: recordings and the model, simulated anew for every setting
- ``settings``: Settings: where the sliders stand
"""
