"""Names that are longer than their place: states and whole words are still seen, nothing is pushed aside."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from view.browser import Browser
from view.watching import serving

from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.view.hub import Hub
from robosc.view.played import Played

MODEL = """robot TheRobotThatInspectsAndCleansTheWarehouseOfTheWholeCompany {
    component TheGripperBehindTheThirdConveyorOnTheLeft {
        outgoing message reading_of_the_sensor_behind_the_left_wheel_of_the_cart with timeout: 1 s, type: boolean
        service grip with identifier: "/grip", request: none, response: none links trigger
        behaviour {
            initial marked state holding_nothing {
                on response from reading_of_the_sensor_behind_the_left_wheel_of_the_cart goto holding_nothing
                on request to grip goto gripping
            }
            state gripping {
                on response, error from grip goto holding_nothing
            }
        }
    }
    interface trigger use Empty from std_srvs
}
"""
SHOWN = """document.querySelector('#overview b').getBoundingClientRect().width > 60
    && document.querySelector('#overview b').getBoundingClientRect().right
        <= document.querySelector('#overview a').getBoundingClientRect().right"""
CUT = """return [...document.querySelectorAll('.drawing .words')].filter((word) => {
    const [text, drawing] = [word.getBBox(), word.ownerSVGElement.viewBox.baseVal];
    return text.x < 0 || text.x + text.width > drawing.width;
}).map((word) => word.textContent)"""
WIDER = """return [...document.querySelectorAll('header, main, .side, .panel')]
    .filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => e.id || e.className || e.tagName)"""


@pytest.mark.parametrize("width", [1400, 800, 390])
def test_the_page_keeps_its_width_and_shows_states(width: int, browser: Browser) -> None:
    hub = Hub()
    played = Played(SingleEvents(supervisor_of(MODEL)), hub)
    with serving(hub, played.answers) as server:
        browser.look(width, 900)
        browser.open(server.url)
        browser.sees("document.querySelector('.words.able') !== null")
        browser.sees("document.querySelector('#overview b').textContent === 'holding_nothing'")
        assert browser.run("return innerWidth") == width
        assert browser.run(f"return {SHOWN}")
        assert browser.run(CUT) == []
        assert browser.run(WIDER) == []
