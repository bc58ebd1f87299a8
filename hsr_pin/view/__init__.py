"""A page to look and try: recordings, the model beside them, and a slider for everything that it may be or lack.

- ``controls``: sliders: what can be set, and how far
- ``page``: Page: what is seen, on viser
- ``scene``: the arm in three dimensions
- ``served``: viser's server, for this machine's own pages alone
- ``session``: Session: recordings and the model, simulated anew for every setting
- ``settings``: Settings: where the sliders stand
"""
