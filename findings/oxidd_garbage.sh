#!/bin/sh
# oxidd 0.13.0 ends an operation with DDMemoryError though nearly all nodes are garbage. It collects
# that by itself, in a thread of its own; while that is about to run, gc() returns at once, with 0,
# and the operation fails once more. A second later it succeeds, with some forty nodes in use. So
# who tries again after gc() has to wait until nodes are gone.
# Functions of 40 variables are built one after the other, each dropped before the next, until one
# fails twice, with gc() between the two. On two processors that takes a second or less.
# Seen: "failed, gc 0, failed again, a second later built, fewer than 200 nodes: True", in one line.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check oxidd==0.13.0
cat > "$folder/run.py" <<'END'
import random
import time

from oxidd.bdd import BDDManager

numbers = random.Random(1)
manager = BDDManager(2**14, 2**12, 1)
variables = [manager.var(number) for number in manager.add_vars(40)]


def is_built(pairs):
    try:
        function = manager.false()
        for left, right in pairs:
            function |= variables[left] & variables[right]
    except MemoryError:
        return False
    return True


end = time.monotonic() + 120
while time.monotonic() < end:
    pairs = [(numbers.randrange(40), numbers.randrange(40)) for _ in range(8)]
    if is_built(pairs):
        continue
    freed = manager.gc()
    if freed or is_built(pairs):
        continue
    time.sleep(1)
    later = "built" if is_built(pairs) else "failed"
    manager.gc()
    few = manager.num_inner_nodes() < 200
    print(f"failed, gc {freed}, failed again, a second later {later}, fewer than 200 nodes: {few}")
    break
END
seen=$("$folder/venv/bin/python" "$folder/run.py")
echo "$seen"
[ "$seen" = "failed, gc 0, failed again, a second later built, fewer than 200 nodes: True" ]
