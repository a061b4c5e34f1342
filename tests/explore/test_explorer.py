"""The explorer in a real browser, with a real server that is killed and started again."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import pytest
import pyvista as pv
from playwright.sync_api import Browser, BrowserContext, Page, expect
from support import chromium

from dolfingrip import config
from dolfingrip.serving.guard import Handover

SHORT = (
    "finger.length_mm=38", "finger.bellows=2", "mesh.size_mm=8", "mesh.edge_size_mm=2",
    "experiment.max_pressure_kPa=60", "experiment.step_kPa=30", "supply.valve_dm3_per_s_bar=0.01",
)  # fmt: skip
SOLVE_MS = 120_000


class Server:
    """An explorer of two parameters of a short coarse finger."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.port = 0
        self.address = ""
        self.process: subprocess.Popen[str] | None = None

    def start(self, *more: str) -> None:
        options = [text for each in SHORT for text in ("--set", each)]
        varied = ["--parameter", "morph.xi1=0:0.4", "--parameter", "finger.wall_mm=1.8:2.2"]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "dolfingrip", "explore", "-o", str(self.out),
             "--port", str(self.port), *options, *varied, *more],
            stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        found = re.fullmatch(r"explorer: (http://127\.0\.0\.1:(\d+)/\?token=\S+)\n", line)
        assert found, line
        self.address, self.port = found[1], int(found[2])

    def kill(self) -> None:
        assert self.process is not None
        os.kill(self.process.pid, signal.SIGKILL)
        self.process.wait()


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    found = Server(tmp_path_factory.mktemp("explorer"))
    found.start()
    yield found
    found.kill()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium.browser() as found:
        yield found


@pytest.fixture(scope="module")
def context(browser: Browser) -> BrowserContext:
    return browser.new_context(viewport={"width": 1280, "height": 900})


@pytest.fixture(scope="module")
def page(context: BrowserContext, server: Server) -> Page:
    found = context.new_page()
    found.goto(server.address)
    found.wait_for_selector("html[data-ready]")
    found.uncheck("#auto")
    return found


def asked(page: Page) -> int:
    """How often a page asked for its design; a design that another tab had solved asks, too."""
    return int(chromium.state(page, "asked"))


def test_a_slider_changes_the_design(page: Page) -> None:
    said = chromium.heard(page)
    before = page.inner_text("#numbers"), page.locator("#view").screenshot()
    assert "COG offset" in before[0]
    assert page.inner_text("#where") == "not solved: the shape without load"
    last = asked(page)
    page.locator("#p-0").press("End")
    page.wait_for_selector(f"html[data-shown='{last + 1}']")
    page.wait_for_timeout(200)
    assert page.input_value("#n-0") == "0.4"
    assert page.inner_text("#numbers") != before[0]
    assert page.locator("#view").screenshot() != before[1]
    page.fill("#n-0", "")
    page.locator("#n-0").blur()
    assert page.input_value("#n-0") == "0.4"  # an empty box is no value
    badge, scale = (page.locator(each).bounding_box() for each in ("#badge", ".scale"))
    assert badge is not None
    assert scale is not None
    assert badge["x"] + badge["width"] <= scale["x"]  # nothing of the scale is hidden
    assert not said.errors


def test_a_design_is_solved_and_exported(page: Page, server: Server, tmp_path: Path) -> None:
    page.click("#solve")
    page.wait_for_selector("html[data-origin='solved by finite elements']", timeout=SOLVE_MS)
    assert page.inner_text("#state") == "solved: 1 of free bending, 0 of blocked force"
    assert page.inner_text("#now") == "60 kPa"
    (folder,) = (server.out / "solved").iterdir()
    assert len(list((server.out / "coarse").iterdir())) == 1
    with (folder / "result.csv").open(encoding="utf-8", newline="") as stream:
        angle = float(list(csv.DictReader(stream))[-1]["angle_deg"])
    told = re.search(r"at 60 kPa\s+([\d.]+)°", page.inner_text("#numbers"))
    assert told
    assert float(told[1]) == pytest.approx(angle, rel=6e-3)  # three digits
    volumes = {}
    for suffix in ("stl", "step", "toml"):
        with page.expect_download() as loading:
            page.click(f"#{suffix}")
        file = tmp_path / loading.value.suggested_filename
        loading.value.save_as(file)
        volumes[suffix] = file
    solid = pv.read(volumes["stl"]).clean()
    assert solid.is_manifold
    assert solid.n_open_edges == 0
    assert solid.volume > 1000
    assert volumes["step"].read_text().startswith("ISO-10303-21;")
    assert re.search(r"^xi1 = 0\.4", volumes["toml"].read_text(encoding="utf-8"), re.MULTILINE)


def test_a_solved_design_has_commands_for_a_curve(page: Page) -> None:
    """One that is slow enough is followed; what is too fast, and no curve, is said."""
    said, charts = page.locator("#follow-said"), page.locator("#follow-chart svg")
    page.fill("#wish-rise_s", "5")
    page.locator("#wish-rise_s").blur()
    expect(said).to_contain_text("it follows the curve within")
    expect(charts).to_have_count(2)
    assert page.inner_text("#follow-key").split("\n") == ["tube", "cavity", "wished", "set point"]
    page.fill("#wish-rise_s", "0.01")
    page.locator("#wish-rise_s").blur()
    expect(said).to_contain_text("though the set point is the highest")
    page.fill("#wish-rise_s", "0")
    page.locator("#wish-rise_s").blur()
    expect(said).to_have_text("rise_s = 0: allowed: 0.001 to 3600 s")
    expect(charts).to_have_count(0)


def test_two_tabs_have_a_design_each(context: BrowserContext, page: Page, server: Server) -> None:
    other = context.new_page()
    other.goto(f"http://127.0.0.1:{server.port}/")  # with the cookie of the first
    other.wait_for_selector("html[data-ready]")
    assert other.inner_text("#state").startswith("solved: 1 of free bending")
    # of one solved design no other is known
    assert other.inner_text("#where") == "not solved: the shape without load"
    assert re.search(r"at 60 kPa\s+–", other.inner_text("#numbers"))
    assert (page.input_value("#n-0"), other.input_value("#n-0")) == ("0.4", "0")
    other.click("#solve")
    other.wait_for_selector("html[data-origin='solved by finite elements']", timeout=SOLVE_MS)
    expect(page.locator("#state")).to_contain_text("solved: 2 of free bending")
    # between the two
    last = asked(page)
    slider = page.locator("#p-0")
    slider.evaluate("node => { node.value = 0.2; node.dispatchEvent(new Event('input')); }")
    page.wait_for_selector(f"html[data-shown='{last + 1}']")
    assert page.inner_text("#where") == (
        "estimate, interpolated between 2 designs solved, too few to tell the error"
    )
    assert page.inner_text("#badge") == "estimate, error unknown"
    assert re.search(r"at 60 kPa\s+–", page.inner_text("#numbers"))
    other.close()


SLIDE = """(node, value) => {
    node.value = value;
    node.dispatchEvent(new Event('input'));
    const hidden = (id) => getComputedStyle(document.querySelector(id)).visibility === 'hidden';
    return ['#view canvas', '#numbers', '#curves', '#where', '.slider output'].map(hidden);
}"""


def test_nothing_of_another_design_is_seen(page: Page) -> None:
    """Not in the task in which the slider moves, nor where there is no such design."""
    last = asked(page)
    assert page.locator("#p-1").evaluate(SLIDE, 2.1) == [True] * 5
    page.wait_for_selector(f"html[data-shown='{last + 1}']:not(.stale)")
    page.fill("#n-1", "2.5")
    page.wait_for_selector(f"html[data-shown='{last + 2}']")
    reason = "Wall thickness = 2.5: allowed: 1.8 to 2.2 mm"
    assert page.inner_text("#error") == page.locator("#solve").get_attribute("title") == reason
    assert page.locator("#solve").is_disabled()
    assert (page.inner_text("#numbers"), page.inner_text("#curves")) == ("", "")
    assert page.locator("#view canvas").first.evaluate("n => getComputedStyle(n).visibility") == (
        "hidden"
    )
    assert page.locator("#stl").get_attribute("href") is None
    assert page.locator("#picture").evaluate("node => node.closest('[inert]') !== null")
    page.fill("#n-1", "2.1")
    page.wait_for_selector("html:not(.stale)")
    assert page.locator("#solve").is_enabled()
    assert "COG offset" in page.inner_text("#numbers")


WATCH = """() => {
    window.seen = {};
    new MutationObserver(() => {
        window.seen[document.documentElement.dataset.origin] = {
            badge: document.querySelector('#badge').textContent,
            numbers: document.querySelector('#numbers').innerText };
    }).observe(document.documentElement, { attributeFilter: ['data-origin'] });
}"""
"""Keeps badge and numbers of all that is shown, however soon the next takes its place."""


def angle_deg(page: Page) -> float:
    return angle_in(page.inner_text("#numbers"))


def angle_in(numbers: str) -> float:
    """Angle (degrees) that the numbers of a page tell."""
    told = re.search(r"at [\d.]+ kPa\s+([\d.]+)°", numbers)
    assert told, numbers
    return float(told[1])


def test_a_design_at_rest_is_solved_coarsely_first(page: Page) -> None:
    page.check("#auto")
    page.evaluate(WATCH)
    page.locator("#p-1").evaluate(SLIDE, 1.9)
    page.locator("#p-1").dispatch_event("change")  # it is let go
    fine = "html:not(.stale)[data-origin='solved by finite elements']"
    page.wait_for_selector(fine, timeout=SOLVE_MS)
    assert page.locator("#badge").is_hidden()
    first = page.evaluate("window.seen['solved on a coarse mesh']")
    assert first["badge"] == "coarse mesh"
    coarse = angle_in(first["numbers"])
    assert coarse == pytest.approx(angle_deg(page), rel=0.1)
    assert coarse != angle_deg(page)
    page.uncheck("#auto")


def test_the_highest_pressure_is_a_slider(page: Page) -> None:
    """Below a pressure that was solved the design's own path tells the shape."""
    whole = angle_deg(page)
    page.fill("#n-pressure", "45")
    page.wait_for_selector("html[data-origin='solved to 60 kPa, interpolated between its steps']")
    assert page.inner_text("#now") == "45 kPa"
    assert angle_deg(page) == pytest.approx(0.75 * whole, rel=0.05)  # nearly a straight line
    page.fill("#n-pressure", "80")
    page.wait_for_selector("html[data-origin='not solved: the shape without load']")
    page.fill("#n-pressure", "60")
    page.wait_for_selector("html[data-origin='solved by finite elements']")


def test_undo_redo_and_a_link(context: BrowserContext, page: Page) -> None:
    pictures = page.locator("#history button")
    page.fill("#n-pressure", "45")
    expect(pictures.last).to_contain_text("45 kPa")
    page.fill("#n-pressure", "60")  # left with the value it was entered with, before it is at rest
    for box, value in (("#n-1", "1.9"), ("#n-0", "0.3"), ("#n-1", "2")):
        page.fill(box, value)
        page.locator(box).blur()

    def values() -> list[str]:
        return [page.input_value(f"#n-{i}") for i in (0, 1)]

    page.click("#undo")
    assert values() == ["0.3", "1.9"]
    page.keyboard.press("Control+z")
    assert values()[0] != "0.3"
    page.click("#redo")
    page.keyboard.press("Control+Shift+z")
    assert values() == ["0.3", "2"]
    assert page.locator("#redo").is_disabled()
    assert pictures.last.inner_text() == "Wall thickness 2 mm"
    page.wait_for_selector("#history button:last-child img")
    other = context.new_page()
    other.goto(page.url)
    other.wait_for_selector("html[data-ready]")
    assert [other.input_value(f"#n-{i}") for i in (0, 1)] == ["0.3", "2"]
    other.click("#cancel", force=True) if other.locator("#working").is_visible() else None
    other.close()
    page.fill("#n-1", "2.2")
    page.locator("#history button", has_text="ξ₁ 0.3").last.click()
    assert values() == ["0.3", "1.9"]


def test_steps_by_keys_are_one_change(page: Page) -> None:
    before = page.input_value("#n-1")
    page.locator("#p-1").focus()
    for _ in range(6):
        page.keyboard.press("ArrowLeft")
    page.wait_for_timeout(900)  # until the design is at rest
    assert page.input_value("#n-1") != before
    page.click("#undo")
    assert page.input_value("#n-1") == before


def test_a_link_of_other_sliders_is_told_and_shows_the_start(
    context: BrowserContext, page: Page, server: Server
) -> None:
    """Of two sliders more, of no gripper, of another explorer's keys, no state, and cut short."""
    linked = page.evaluate("decodeURIComponent(location.hash.slice('#design='.length))")
    state = json.loads(linked)
    for foreign in (
        {**state, "values": [*state["values"], 1.0, 2.0]},
        {key: value for key, value in state.items() if key != "gripper"},
        {**state, "of": "finger.depth_mm,finger.wall_mm"},
        {},
        None,
        linked[: len(linked) // 2],
    ):
        other = context.new_page()
        said = chromium.heard(other)
        text = foreign if isinstance(foreign, str) else json.dumps(foreign)
        other.goto(f"http://127.0.0.1:{server.port}/#design={quote(text)}")
        other.wait_for_selector("html[data-ready]")
        assert "COG offset" in other.inner_text("#numbers")
        assert "other sliders" in other.inner_text("#error")
        assert not said.errors
        other.close()


def test_a_link_is_copied_without_the_browsers_clipboard(
    context: BrowserContext, page: Page, server: Server
) -> None:
    """As with http from another machine, where browsers have none."""
    other = context.new_page()
    said = chromium.heard(other)
    other.add_init_script("Object.defineProperty(navigator, 'clipboard', {value: undefined})")
    other.goto(f"http://127.0.0.1:{server.port}/")
    other.wait_for_selector("html[data-ready]")
    other.click("#link")
    expect(other.locator("#link")).to_have_text("Copied")
    assert not said.errors
    assert "None" not in other.evaluate(
        "document.documentElement.outerHTML.match(/value=.None./)?.[0] ?? ''"
    )
    other.close()


def test_a_tab_is_told_that_another_took_its_place(
    context: BrowserContext, page: Page, server: Server
) -> None:
    tabs = []
    for value in ("1.83", "1.87"):
        tab = context.new_page()
        tab.goto(f"http://127.0.0.1:{server.port}/")
        tab.wait_for_selector("html[data-ready]")
        tab.uncheck("#auto")
        last = asked(tab)
        tab.fill("#n-1", value)
        tab.wait_for_selector(f"html[data-shown='{last + 1}']")
        tabs.append(tab)
    for tab in tabs:
        tab.click("#solve")
    expect(tabs[0].locator("#error")).to_contain_text("took the place of this design")
    assert tabs[1].locator("#error").is_hidden()
    tabs[1].click("#cancel")
    for tab in tabs:
        tab.close()


def test_one_slider_for_all_chambers_opens_into_one_for_each(
    context: BrowserContext, page: Page, tmp_path: Path
) -> None:
    def walls(tab: Page = page) -> list[str]:
        return [tab.input_value(f"#n-{i}") for i in ("1", "1-1", "1-2")]

    page.fill("#n-1", "1.9")
    assert page.locator("#c-1").is_hidden()
    page.click(".each[data-of='1']")
    assert walls() == ["1.9", "1.9", "1.9"]
    before = page.locator("#view").screenshot()
    page.fill("#n-1-2", "2.1")
    page.wait_for_selector("html:not(.stale)")
    page.wait_for_timeout(200)
    assert page.locator("#view").screenshot() != before
    page.locator("#n-1-2").blur()
    pictures = page.locator("#history button")
    assert pictures.last.inner_text() == "Wall thickness of chamber 2 2.1 mm"
    page.fill("#n-1", "2")  # those without a value of their own follow
    page.locator("#n-1").blur()
    assert walls() == ["2", "2", "2.1"]
    with page.expect_download() as loading:
        page.click("#toml")
    loading.value.save_as(tmp_path / "design.toml")
    assert config.load(tmp_path / "design.toml").finger.of(1).wall_mm == 2.1
    other = context.new_page()
    other.goto(page.url)
    other.wait_for_selector("html[data-ready]")
    assert other.locator("#c-1").is_visible()
    assert walls(other) == ["2", "2", "2.1"]
    other.close()
    page.fill("#n-1-1", "2.5")
    page.wait_for_selector("#error:not([hidden])")
    assert page.inner_text("#error") == "Wall thickness of chamber 1 = 2.5: allowed: 1.8 to 2.2 mm"
    page.click("#undo")
    page.click("#undo")
    assert walls() == ["1.9", "1.9", "2.1"]
    page.click(".each[data-of='1']")
    assert page.locator("#c-1").is_hidden()
    assert walls() == ["1.9", "1.9", "1.9"]
    page.click("#undo")
    assert walls() == ["1.9", "1.9", "2.1"]
    page.click(".each[data-of='1']")


def test_the_gripper_is_placed(page: Page) -> None:
    said = chromium.heard(page)
    page.fill("#n-0", "0.4")
    page.fill("#n-1", "1.8")
    page.wait_for_selector("html[data-origin='solved by finite elements']")
    last = asked(page)
    page.click("[data-view=grasp]")
    page.wait_for_selector(f"html[data-shown='{last + 1}']")
    assert page.locator("#gripper").is_visible()
    assert "to 60 kPa, and do not feel the food" in page.inner_text("#where")
    pinch = page.locator("#view").screenshot()
    page.select_option("#pose", "claw")
    page.wait_for_selector(f"html[data-shown='{last + 2}']")
    page.wait_for_timeout(200)
    assert page.inner_text("#o-alpha") == "0°"
    assert page.locator("#view").screenshot() != pinch
    page.fill("#R_mm", "0.1")
    page.locator("#R_mm").blur()
    page.wait_for_selector("#error:not([hidden])")
    assert re.match(r"gripper: .*allowed: larger", page.inner_text("#error"))
    page.fill("#R_mm", "")
    page.locator("#R_mm").blur()
    page.wait_for_selector("#error[hidden]", state="attached")
    page.click("[data-view=bending]")
    assert not said.errors


def test_the_wizard(page: Page) -> None:
    page.click("#make")
    page.wait_for_selector("#made:not([hidden])")
    assert "wall_mm" in page.inner_text("#setup")
    assert page.inner_text("#csv-header").startswith("experiment,specimen,cycle,branch,")
    page.fill("#cycles", "0")
    page.click("#make")
    page.wait_for_selector("#rig-error:not([hidden])")
    assert page.inner_text("#rig-error") == "cycles = 0: allowed: at least 1 and at most 100"
    page.fill("#cycles", "1")
    page.fill("#hold_s", "")
    page.click("#make")
    expect(page.locator("#rig-error")).to_have_text(
        "Wait after the first ramp (s): empty; allowed: a number"
    )
    page.fill("#hold_s", "0")


def test_a_phone(context: BrowserContext, server: Server) -> None:
    page = context.new_page()
    page.set_viewport_size({"width": 400, "height": 800})
    page.goto(f"http://127.0.0.1:{server.port}/")
    page.wait_for_selector("html[data-ready]")
    assert chromium.overflow_px(page) <= 0
    page.close()


def test_a_server_that_is_killed_and_started_again(page: Page, server: Server) -> None:
    page.fill("#n-1", "1.8")
    page.locator("#p-0").press("End")
    server.kill()
    page.wait_for_selector("html[data-connected=false]")
    assert page.inner_text("#state").startswith("not connected")
    address = server.address
    server.start("--restart")
    assert server.address == address
    page.wait_for_selector("html[data-connected=true]")
    page.wait_for_selector("html[data-origin='solved by finite elements']")
    assert re.match(r"solved: \d+ of free bending", page.inner_text("#state"))
    # not asked to: a server lets in nobody of the one before
    server.kill()
    server.start()
    assert server.address != address
    page.wait_for_selector("html[data-connected=false]")
    assert page.goto(address).status == 403


def test_the_browser_is_led_by_a_file(browser: Browser, server: Server) -> None:
    """Its command line, which every user of the machine can read, has no token."""
    handed = Handover.of(server.out)
    assert stat.S_IMODE(handed.file.stat().st_mode) == 0o600
    page = browser.new_context().new_page()  # without a cookie
    page.goto(handed.file.as_uri())
    page.wait_for_selector("html[data-ready]")
    assert page.url == f"http://127.0.0.1:{server.port}/"
    page.close()
    token = server.address.partition("token=")[2]
    results = [each for each in server.out.rglob("*") if each.is_file()]
    assert not [each for each in results if token.encode() in each.read_bytes()]
