"""What ``ros2 run robosc VERB`` starts: setup.py makes an entry point of each, named as in
robosc_ros1/scripts, which ``rosrun`` starts."""

from functools import partial

from robosc.start import run

robosc = run
check = partial(run, "check")
explain = partial(run, "explain")
explore = partial(run, "explore")
export = partial(run, "export")
format = partial(run, "format")
generate = partial(run, "generate")
lsp = partial(run, "lsp")
mcp = partial(run, "mcp")
new = partial(run, "new")
replay = partial(run, "replay")
report = partial(run, "report")
simulate = partial(run, "simulate")
synthesize = partial(run, "synthesize")
verify = partial(run, "verify")
view = partial(run, "view")
