"""A command for which a preferred one is sent is shown as one that waits, wherever it is shown."""

from __future__ import annotations

from pathlib import Path

from emit.generated_code import supervisor_of
from view.browser import Browser
from view.watching import command_is, log_of, serving

from robosc.runtime.core.settings import Settings
from robosc.simulate.machines.execute import Execution
from robosc.view.exported import html_of
from robosc.view.hub import Hub
from robosc.view.played import Played
from robosc.view.recorded import Recording

MODEL = """robot Rover {
    component Laser {
        outgoing message clear with type: boolean
        behaviour { variable free: boolean initial marked state on { on response from clear do free := value } }
    }
    component Motor {
        incoming message drive with type: double
        incoming message halt with type: double
    }
    requirement drive needs Laser.free
    prefer drive over halt
    provide drive with 0.2
    provide halt with 0.0
}
"""
REASON = "document.querySelector('[data-command=\"halt.request\"] .reasons')?.textContent"


def test_a_model_that_is_played(browser: Browser) -> None:
    hub = Hub()
    source = Played(Execution(supervisor_of(MODEL), Settings()), hub)
    with serving(hub) as server:
        browser.open(server.url)
        browser.sees(command_is("halt.request", "enabled"))
        browser.sees(command_is("drive.request", "forbidden"))
        source.do({"event": {"kind": "response", "name": "clear", "value": True}})
        browser.sees(command_is("halt.request", "waiting"))
        browser.sees(command_is("drive.request", "enabled"))
        browser.sees(f"{REASON} === 'waits for drive, which is preferred'")
        browser.picture("view-preference")
        source.do({"event": {"kind": "response", "name": "clear", "value": False}})
        browser.sees(command_is("halt.request", "enabled"))
        browser.sees(f"{REASON} === ''")


def test_a_recording_in_a_file(browser: Browser, tmp_path: Path) -> None:
    supervisor = supervisor_of(MODEL)
    log = tmp_path / "events.log"
    steps = (("clear", "response", True), 0.2, ("clear", "response", False), 0.2)
    log.write_text("\n".join(log_of(supervisor, *steps)) + "\n", encoding="utf-8")
    recording = Recording(supervisor, str(log), Hub())
    count = recording.hello["count"]
    page = tmp_path / "run.html"
    page.write_text(html_of(recording), encoding="utf-8")
    browser.open(page.as_uri())
    browser.sees(f"recording.count === {count}")
    places = list(range(1, count + 1))
    told = browser.run("return arguments[0].map((at) => exported.moment({at}))", places)
    assert told == [recording.moment({"at": place}) for place in places]
    waits = [{c["event"]["name"]: c["waits_for"] for c in m["state"]["commands"]} for m in told]
    assert {tuple(w["halt"]) for w in waits} == {(), ("drive",)}
