"""The finite view of data: unbounded numbers and strings as the plant sees them.

A *term* is what deciding expressions ask of data: a variable or a part of ``value`` that is
compared with constants, or what is computed of several. The plant has each term as a state variable
(or, where it reads ``value``, as a parameter of the event) whose values are the *classes* that no
comparison of the model distinguishes, one representative each. See docs/semantics.md.
"""
