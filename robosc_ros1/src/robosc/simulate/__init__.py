"""Playing a robot without ROS: its events by hand, by script or at random, and replaying its logs.

A *machine* plays: :class:`~robosc.simulate.machines.event_by_event.SingleEvents` takes one event of
the supervised system at a time, :class:`~robosc.simulate.machines.execute.Execution` is the
generated controller on a virtual clock. A :class:`~robosc.simulate.script.session.Session`
understands the lines of the script language and lets a machine do them. Terminal, script and JSON
are three ways to feed it lines.
"""
