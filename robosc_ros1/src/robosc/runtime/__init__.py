"""What runs a generated controller: event queue, pace, calls, parameters, reports.

This package is copied verbatim into every generated package. It knows neither robosc nor any
middleware, needs nothing but Python 3.8, and is the same for ROS 1 and ROS 2: the node brings a
:class:`~.port.Port` that reaches the middleware, and ``controller.py`` brings the model.
"""
