"""``robosc report``: what it says of each requirement is what synthesis, proof and runs say."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from ros_support import Completed
from runtime.schemas import validate
from simulate import test_logs_of_large_values as large
from simulate.players import session
from simulate.test_replay import lines_of, run_of, write

from robosc import pipeline
from robosc.evidence.document import rendered
from robosc.evidence.runs import recorded_runs
from robosc.supervisor import Supervisor

Robosc = Callable[..., Completed]
MODEL = """robot Cart {
    component Base {
        outgoing message front with identifier: "/front", timeout: 1 s, type: double
        incoming message go with identifier: "/go", type: none
        incoming message halt with identifier: "/halt", type: none
        behaviour {
            variable near: double = 0.0
            initial marked state rest {
                on response from front do near := value
                on request to go goto driving
            }
            state driving {
                on response from front do near := value
                on request to halt goto rest
            }
        }
    }
    requirement "SR-1 far from things" go needs front.fresh and Base.near > 0.4
    requirement "SR-2 <b>stop</b> | near" halt needs Base.near <= 0.4 or front.silent
    requirement "SR-3 never stuck" possible Base.rest
    assume "A-1 sensor" front needs value >= 0.0
    stop with halt
}"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "cart.rscd"
    path.write_text(MODEL, encoding="utf-8")
    return path


@pytest.fixture
def supervisor(model: Path) -> Supervisor:
    return pipeline.supervise(pipeline.load(model).robot)


def document(done: Completed, path: Path) -> Any:
    assert done.returncode in (0, 1), done.stderr
    found = json.loads(path.read_text(encoding="utf-8"))
    validate(found, "report")
    return found


def by_id(found: Any) -> dict[str, Any]:
    return {requirement["id"]: requirement for requirement in found["requirements"]}


def test_each_requirement_with_its_commands_and_what_is_proved(
    robosc: Robosc, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "evidence.json"
    found = document(robosc("report", str(model), "--output", str(out)), out)
    assert found["model"]["files"][0]["sha256"] == sha256(MODEL.encode()).hexdigest()
    shown = by_id(found)
    assert list(shown) == ["SR-1", "SR-2", "SR-3"]
    assert [c["command"] for c in shown["SR-1"]["commands"]] == ["go.request"]
    assert shown["SR-1"]["proved"] == "safe"
    assert "always possible" in shown["SR-3"]["proved"]
    assert [a["id"] for a in found["assumptions"]] == ["A-1"]
    assert found["verification"]["verified"] is True
    assert found["runs"] == []


def test_equal_inputs_give_equal_bytes(robosc: Robosc, model: Path, tmp_path: Path) -> None:
    for suffix in ("html", "md", "json"):
        texts = []
        for name in ("a", "b"):
            out = tmp_path / f"{name}.{suffix}"
            assert robosc("report", str(model), "--output", str(out)).returncode == 0
            texts.append(out.read_bytes())
        assert texts[0] == texts[1]


def test_the_page_is_one_file_that_shows_text_as_text(
    robosc: Robosc, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "evidence.html"
    assert robosc("report", str(model), "--output", str(out)).returncode == 0
    page = out.read_text(encoding="utf-8")
    assert not re.search(r"(?:src|href)=|@import|url\(", page)
    assert "<b>stop" not in page and "&lt;b&gt;stop" in page
    for text in ("SR-1", "SR-2", "SR-3", "A-1 sensor", "no certification"):
        assert text in page


def test_where_a_log_shows_it_stopping_a_command(
    robosc: Robosc, model: Path, supervisor: Supervisor, tmp_path: Path
) -> None:
    player = session(supervisor, execute=True)
    lines = run_of(player, "front 2", "front 0.3", "front 0.2", "front 3", "wait 2", "front 0.1")
    log = write(tmp_path / "run.jsonl", lines_of(lines))
    out = tmp_path / "evidence.json"
    done = robosc("report", str(model), "--logs", log, "--output", str(out))
    found = document(done, out)
    assert done.returncode == 0
    first = by_id(found)["SR-1"]["first"]
    assert first["command"] == "Base.go"
    assert any("Base.near is 0.3" in value for value in first["values"])
    # Anew: at 0.3, once it rests again; when it falls silent; each after it was allowed between.
    assert by_id(found)["SR-1"]["stopped"] == _began(supervisor, lines_of(lines), "SR-1")
    assert by_id(found)["SR-2"]["stopped"] == _began(supervisor, lines_of(lines), "SR-2")
    (run,) = found["runs"]
    assert not run["faulty"] and run["events"] > 5
    again = robosc("report", str(model), "--logs", log)
    assert re.search(
        r"held a command back \d+ times? in the logs, first Base.go (at .+ )?in ", again.stdout
    )


@pytest.mark.parametrize(
    ("moment", "told"),
    [
        (
            1796065973.843987,
            "1 time in the logs, first Base.go at 2026-11-30 19:12:53 UTC in run.log",
        ),
        (12.5, "1 time in the logs, first Base.go at 12.500 s in run.log"),
        (1e12, "1 time in the logs, first Base.go at 1000000000000.000 s in run.log"),
        (None, "1 time in the logs, first Base.go in run.log"),
    ],
)
@pytest.mark.parametrize("suffix", [".md", ".html"])
def test_when_it_stopped_a_command_is_told_as_people_read_it(
    suffix: str,
    moment: float | None,
    told: str,
    robosc: Robosc,
    model: Path,
    tmp_path: Path,
) -> None:
    out = tmp_path / "evidence.json"
    found = document(robosc("report", str(model), "--output", str(out)), out)
    first = {"run": "run.log", "time": moment, "command": "Base.go", "values": []}
    found["requirements"][0] |= {"stopped": 1, "first": first}
    assert f"held a command back {told}" in rendered(found, suffix)


def _began(supervisor: Supervisor, lines: list[str], requirement: str) -> int:
    """How often it begins to hold back its command, read off the events by hand."""
    near, fresh, driving, count, before = 0.0, False, False, 0, False
    for text in lines:
        event = json.loads(text)["event"]
        match event["name"], event["kind"]:
            case "front", "response":
                near, fresh = event["value"], True
            case "front", "timeout":
                fresh = False
            case "go", "request":
                driving = True
            case "halt", "request":
                driving = False
        if requirement == "SR-1":
            holds = not driving and not (fresh and near > 0.4)
        else:
            holds = driving and not (near <= 0.4 or not fresh)
        count += holds and not before
        before = holds
    return count


def test_a_violation_in_a_log_is_told_with_its_requirement(
    robosc: Robosc, model: Path, supervisor: Supervisor, tmp_path: Path
) -> None:
    player = session(supervisor, execute=True)
    lines = lines_of(run_of(player, "front 2"))
    place = next(n for n, line in enumerate(lines) if '"go"' in line)
    faulty = lines[place].replace(f'"number":{place + 1}', '"number":1')
    log = write(tmp_path / "run.jsonl", [faulty])
    out = tmp_path / "evidence.json"
    done = robosc("report", str(model), "--logs", log, "--output", str(out))
    found = document(done, out)
    assert done.returncode == 1
    (violation,) = by_id(found)["SR-1"]["violations"]
    assert "go" in violation["told"] and by_id(found)["SR-2"]["violations"] == []
    assert found["runs"][0]["faulty"]
    assert "VIOLATED" in robosc("report", str(model), "--logs", log).stdout


def edited(lines: list[str]) -> list[str]:
    """Lines of a log with the numbers that they would have in a run of their own."""
    documents = [json.loads(line) for line in lines]
    return [json.dumps({**d, "number": n}) for n, d in enumerate(documents, 1)]


def test_a_requirement_is_not_accused_of_what_is_against_a_longer_one(
    robosc: Robosc, tmp_path: Path
) -> None:
    """Its text is the beginning of the other's."""
    text = MODEL.replace('"SR-1 far from things" ', "").replace(
        "assume", "requirement go needs front.fresh  assume"
    )
    path = tmp_path / "cart.rscd"
    path.write_text(text, encoding="utf-8")
    player = session(pipeline.supervise(pipeline.load(path).robot), execute=True)
    lines = lines_of(run_of(player, "front 0.3", "front 2"))
    went = next(line for line in lines if '"go"' in line)
    log = write(tmp_path / "run.jsonl", edited([lines[0], went]))
    out = tmp_path / "evidence.json"
    found = document(robosc("report", str(path), "--logs", log, "--output", str(out)), out)
    accused = [r["text"] for r in found["requirements"] if r["violations"]]
    assert accused == ["requirement go needs front.fresh and Base.near > 0.4"]


def test_a_log_that_lost_events_is_not_told_as_required(
    robosc: Robosc, model: Path, supervisor: Supervisor, tmp_path: Path
) -> None:
    lines = lines_of(run_of(session(supervisor, execute=True), "front 2", "front 0.3", "front 3"))
    log = write(tmp_path / "run.jsonl", [lines[0], *lines[2:]])
    out = tmp_path / "evidence.json"
    done = robosc("report", str(model), "--logs", log, "--output", str(out))
    assert done.returncode == 2
    (run,) = json.loads(out.read_text(encoding="utf-8"))["runs"]
    assert (run["faulty"], run["complete"]) == (False, False)
    assert any("missing" in told for told in run["found"])
    assert "as far as it could be judged" in robosc("report", str(model), "--logs", log).stdout


def test_what_no_log_shows_is_not_told(robosc: Robosc, tmp_path: Path) -> None:
    """Without a log, of what the data of a command decide, and of what is about states."""
    text = MODEL.replace("type: none", "type: double", 1).replace(
        "assume",
        'requirement "SR-4" go needs value < 1.0 requirement "SR-5" always Base.near >= 0.0 assume',
    )
    path = tmp_path / "cart.rscd"
    path.write_text(text, encoding="utf-8")
    out = tmp_path / "evidence.json"
    found = by_id(document(robosc("report", str(path), "--output", str(out)), out))
    assert {r["stopped"] for r in found.values()} == {None}
    assert "in the logs" not in robosc("report", str(path)).stdout
    player = session(pipeline.supervise(pipeline.load(path).robot), execute=True)
    log = write(tmp_path / "run.jsonl", lines_of(run_of(player, "front 2")))
    done = robosc("report", str(path), "--logs", log, "--output", str(out))
    found = by_id(document(done, out))
    assert found["SR-5"]["stopped"] is None and found["SR-3"]["stopped"] is None
    assert found["SR-2"]["stopped"] is not None


def test_a_cancel_that_nothing_demands_is_told(robosc: Robosc, tmp_path: Path) -> None:
    """The reasons name requirements that hold; none of them is violated."""
    text = """robot Lift {
        interface park use Fibonacci from actionlib_tutorials
        component Arm {
            outgoing message up with type: boolean, timeout: 1 s
            action park with request: none, response: none, feedback: none links park
            behaviour {
                variable high: boolean
                initial marked state rest {
                    on response from up do high := value
                    on request to park goto busy
                }
                state busy {
                    on response from up do high := value
                    on response, error, cancelled from park goto rest
                }
            }
        }
        requirement "SR-1" park needs Arm.high
    }"""
    path = tmp_path / "lift.rscd"
    path.write_text(text, encoding="utf-8")
    player = session(pipeline.supervise(pipeline.load(path).robot), execute=True)
    lines = lines_of(run_of(player, "up true", "up false"))
    cancel = next(line for line in lines if '"cancel"' in line)
    begun = next(n for n, line in enumerate(lines) if '"park"' in line)
    log = write(tmp_path / "run.jsonl", edited([*lines[: begun + 1], cancel]))
    out = tmp_path / "evidence.json"
    found = document(robosc("report", str(path), "--logs", log, "--output", str(out)), out)
    assert by_id(found)["SR-1"]["violations"] == []
    (run,) = found["runs"]
    assert run["faulty"] and any("this requirement holds" in told for told in run["found"])


def test_where_values_are_cut_it_is_said_that_nobody_knows(tmp_path: Path) -> None:
    """Their short forms decide nothing; whole, the same run leaves nothing open."""
    supervisor = supervisor_of(large.MODEL)
    logs = {}
    for whole in (False, True):
        lines = large.run(supervisor, 3, 60, whole_values=whole)
        logs[whole] = Path(write(tmp_path / f"run_{whole}.jsonl", lines))
    quiet = lambda *words: None  # noqa: E731
    cut, known = (recorded_runs(supervisor, [logs[w]], [], quiet) for w in (False, True))
    assert any("values are cut" in told for told in cut.runs[0].found)
    assert known.runs[0].found == ()
    text = "requirement pass needs any(r > 3.5 for r in Front.last.ranges) and Front.away"
    assert (known.shown[text].stopped or 0) > 0


def test_a_model_with_libraries_names_all_its_files(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "geo.rscd").write_text("library Geo { constant limit: double = 0.4 }")
    path = tmp_path / "cart.rscd"
    path.write_text(MODEL.replace("> 0.4", "> Geo.limit"), encoding="utf-8")
    out = tmp_path / "evidence.json"
    found = document(robosc("report", str(path), "--output", str(out)), out)
    assert [file["file"] for file in found["model"]["files"]] == ["cart.rscd", "geo.rscd"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--output", "evidence.pdf"), "a report is .html, .md or .json"),
        (("--logs", "missing.jsonl"), "missing.jsonl"),
        (("--bags", "missing.bag"), "missing.bag"),
    ],
)
def test_what_cannot_be_done_writes_nothing(
    robosc: Robosc, model: Path, tmp_path: Path, words: tuple[str, ...], told: str
) -> None:
    before = sorted(tmp_path.iterdir())
    done = robosc("report", str(model), *words)
    assert done.returncode == 2 and told in done.stderr and "Traceback" not in done.stderr
    assert sorted(tmp_path.iterdir()) == before


def test_runs_of_the_packages_test(robosc: Robosc, model: Path, tmp_path: Path) -> None:
    """Named are scripts that ``generate`` writes: the command is sent there, or named as disabled."""
    out = tmp_path / "evidence.json"
    shown = by_id(document(robosc("report", str(model), "--output", str(out)), out))
    assert shown["SR-3"]["tested"] is None
    assert (
        robosc("generate", str(model), "--target", "ros1", "--output", str(tmp_path)).returncode
        == 0
    )
    scripts = tmp_path / "cart_controller" / "test" / "scripts"
    for id_, command in (("SR-1", "go"), ("SR-2", "halt")):
        for side, words in (
            ("met", f"expect sent {command}.request"),
            ("violated", f"expect disabled {command}.request because {id_} "),
        ):
            told = shown[id_]["tested"][side]
            assert told["runs"] and told["why_not"] is None
            for name in told["runs"]:
                assert words in (scripts / f"{name}.sim").read_text(encoding="utf-8"), name


OF_DATA = """robot Cart {
    component Base {
        outgoing message beat with identifier: "/beat", timeout: 5 s, type: boolean
        incoming message go with identifier: "/go", type: double
    }
    requirement "SR-1 fresh" go needs beat.fresh
    requirement "SR-2 slow" go needs value <= 0.5
    provide go with 0.25
    stop with nothing
}"""


@pytest.mark.parametrize("kind", ["bag", "mcap"])
@pytest.mark.parametrize(("speed", "code"), [(0.5, 0), (0.75, 1)])
def test_a_bag_is_judged_as_replay_does(
    robosc: Robosc, tmp_path: Path, kind: str, speed: float, code: int
) -> None:
    """The model's own controller sends other data, which say nothing of those in a bag."""
    pytest.importorskip("rosbags")
    from simulate.recorded_runs import START, BagWriter

    model = tmp_path / "cart.rscd"
    model.write_text(OF_DATA, encoding="utf-8")
    writer = BagWriter(tmp_path / f"run.{kind}", {})
    writer.write("/beat", "std_msgs/msg/Bool", START, {"data": True})
    writer.write("/go", "std_msgs/msg/Float32", START + 1, {"data": speed})
    writer.close()
    replayed = robosc("replay", str(model), str(writer.path))
    out = tmp_path / "evidence.json"
    done = robosc("report", str(model), "--bags", str(writer.path), "--output", str(out))
    assert (done.returncode, replayed.returncode) == (code, code), replayed.stdout
    shown = by_id(document(done, out))
    told = [violation["told"] for violation in shown["SR-2"]["violations"]]
    assert len(told) == code
    assert all(line.endswith("value is 0.75") for line in told)
    assert replayed.stdout.count("value is 0.75") == code
    assert shown["SR-1"]["violations"] == []


def test_what_is_cited_as_one_requirement_is_one(robosc: Robosc, tmp_path: Path) -> None:
    """One in a component that is imported twice, and one on the data of several commands."""
    (tmp_path / "Lamps.rscd").write_text("""library Lamps {
        component Lamp {
            incoming message glow with identifier: "glow", type: double
            outgoing message hot with identifier: "hot", timeout: 1 s, type: none
            requirement glow needs hot.fresh
        }
    }""")
    model = tmp_path / "room.rscd"
    model.write_text("""robot Room {
        component Left from Lamps import Lamp with prefix: "/left"
        component Right from Lamps import Lamp with prefix: "/right"
        requirement { Left.glow, Right.glow } needs value <= 2.0
        provide Left.glow with 1.0 if Left.hot.fresh else with 3.0
        provide Right.glow with 1.0
        stop with nothing
    }""")
    done = robosc("report", str(model), "--output", str(tmp_path / "evidence.json"))
    found = document(done, tmp_path / "evidence.json")
    commands = {r["text"]: [c["command"] for c in r["commands"]] for r in found["requirements"]}
    both = ["Left.glow.request", "Right.glow.request"]
    assert commands == {
        "requirement { Left.glow, Right.glow } needs value <= 2.0": both,
        "requirement glow needs hot.fresh": both,
    }
    data, fresh = sorted(found["requirements"], key=lambda r: r["text"], reverse=True)
    assert fresh["tested"]["met"]["runs"] and fresh["tested"]["violated"]["runs"]
    assert data["tested"]["met"]["runs"], "of Right, which comes last, it is no case"
