"""The live picture of a robot in a browser.

A *source* (:mod:`~robosc.view.played`, :mod:`~robosc.view.recorded`,
:mod:`~robosc.view.listening`) puts documents into a :class:`~robosc.view.hub.Hub`;
:mod:`~robosc.view.server` hands them to any number of browsers. The documents are those of a
running controller (``docs/schemas``), whatever the source, so the page is one for all of them. It
lies in ``page/`` and needs no network.
"""
