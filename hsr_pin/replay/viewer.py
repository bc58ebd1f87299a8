"""Import of meshcat without the deprecation warning for the event loop of pyzmq that it uses."""

import warnings

with warnings.catch_warnings():
    warnings.filterwarnings("ignore", "zmq.eventloop.ioloop is deprecated", DeprecationWarning)
    import meshcat.animation as animation
    import meshcat.geometry as geometry
    import meshcat.transformations as transformations
    from meshcat import Visualizer
    from meshcat.path import Path
    from meshcat.servers.zmqserver import VIEWER_ROOT

__all__ = ["VIEWER_ROOT", "Path", "Visualizer", "animation", "geometry", "transformations"]
