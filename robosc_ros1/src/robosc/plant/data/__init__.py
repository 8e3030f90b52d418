"""The finite view of data: unbounded numbers and strings as finite state variables.

A *term* is what a condition compares or tests: a variable or a part of ``value``, or an expression
over several of them. In the plant each term is a state variable (or, if it reads ``value``, a
parameter of the event). Its values are the *classes* of values that no comparison in the model
distinguishes, with one representative each. See docs/semantics.md.
"""
