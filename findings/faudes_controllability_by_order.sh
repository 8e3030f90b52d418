#!/bin/sh
# libFAUDES (faudes 2.34.5 of PyPI): whether an event of a composition is controllable depends on the
# order of the operands. Where two automata disagree about an event that they share, Parallel() takes
# what the second says, without an error. An automaton that only hears an event disagrees easily: an
# event that is inserted is uncontrollable until it is declared otherwise. So the same plant has a
# supervisor or none; the other way round a fault becomes an event that the supervisor may forbid.
# Seen: "Parallel(robot, counter): go controllable False, supervisor 0 states; Parallel(counter,
# robot): go controllable True, supervisor 4 states", in one line.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check faudes==2.34.5
cat > "$folder/run.py" <<'END'
import faudes


def automaton(transitions, controllable):
    made = faudes.System()
    for state in sorted({state for source, _, target in transitions for state in (source, target)}):
        made.InsState(state)
    for source, event, target in transitions:
        made.InsEvent(event)
        made.SetTransition(source, event, target)
    for event in controllable:
        made.SetControllable(event)
    made.SetInitState(transitions[0][0])
    made.SetMarkedState(transitions[0][0])
    return made


robot = automaton([("resting", "go", "driving"), ("driving", "arrived", "resting")], ["go"])
counter = automaton(
    [("zero", "go", "one"), ("one", "go", "two"), ("one", "reset", "zero"), ("two", "reset", "zero")],
    ["reset"],
)
allowed = automaton(  # never a second "go" before "reset"
    [("none", "go", "one"), ("none", "arrived", "none"), ("one", "arrived", "one"),
     ("one", "reset", "none")],
    ["go", "reset"],
)
told = []
parts = {"robot": robot, "counter": counter}
for names in (("robot", "counter"), ("counter", "robot")):
    plant, supervisor = faudes.System(), faudes.System()
    faudes.Parallel(*(parts[name] for name in names), plant)
    faudes.SupCon(plant, allowed, supervisor)
    can_forbid = plant.Controllable("go")
    told.append(
        f"Parallel({', '.join(names)}): go controllable {can_forbid},"
        f" supervisor {supervisor.Size()} states"
    )
print("; ".join(told))
END
cd "$folder"
seen=$("$folder/venv/bin/python" run.py 2> log | grep Parallel)
echo "$seen"
[ "$seen" = "Parallel(robot, counter): go controllable False, supervisor 0 states; Parallel(counter, robot): go controllable True, supervisor 4 states" ]
