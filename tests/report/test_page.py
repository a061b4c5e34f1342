"""The page of a report, in a real browser: one page of two runs, a front and a diagnosis."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import matplotlib.pyplot as plt
import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect
from support import chromium, synthetic_run

from dolfingrip import config
from dolfingrip.charts.chart import Axis
from dolfingrip.files import table
from dolfingrip.files.diagnosis import (
    Advice,
    CauseProbability,
    DiagnosisFile,
    FittedHypothesis,
    FittedNumber,
    Headline,
    Verdict,
)
from dolfingrip.files.diagnosis_words import lines
from dolfingrip.report.page import front, html, sources
from dolfingrip.report.page.content import Front, FrontPoint
from dolfingrip.report.page.finger import unloaded_shape
from dolfingrip.sections.tables import assignments

HOSTILE = "</script><script>window.stolen = 1</script>"
LAST = len(synthetic_run.PRESSURES_KPA) - 1


@dataclass
class Opened:
    """The page, and what it said since it was opened."""

    page: Page
    said: chromium.Heard


def write_diagnosis(folder: Path, pressures: int = 9) -> None:
    """A diagnosis whose cause removes a difference of ten sigma, of this many pressures."""
    verdict = {"answer": "cause", "class": ["yeoh"], "probability": 0.9, "claimed": True,
               "takes_part": 0.9}  # fmt: skip
    number = FittedNumber(key="extensions.yeoh.C20_MPa", value=-0.1, low=-0.12, high=-0.08,
                          unit="MPa", part="yeoh")  # fmt: skip
    fit = FittedHypothesis(effects=("yeoh",), log_evidence=50.0, parameters=(number,))
    DiagnosisFile(
        version="0", data=(), quick=False, readings=18, verdict=Verdict.model_validate(verdict),
        headline=Headline(number=number, cause="yeoh", option="--config extended.toml"),
        causes=(CauseProbability(name="yeoh", words="softening at large strain", probability=0.9,
                                 strength_sigma=10.0),),
        none=0.01, unknown=0.09, fits=(fit,),
        advice=Advice(way="other_channel"), simulated_s=0.0,
    ).write(folder)  # fmt: skip
    names = ("channel", "experiment", "specimen", "run", "branch", "pressure_kPa",
             "displacement_mm", "value", "noise", "configured", "before", "after")  # fmt: skip
    loads = np.linspace(0, 200, pressures)
    rows = []
    for branch, lag, load in (("loading", 0.0, loads), ("unloading", 2.0, loads[::-1])):
        for p in load:
            angle = 0.5 * p + lag
            told = (p, None, angle, 0.5, angle - lag - 5, angle - lag - 5, angle)
            who = ("angle_deg", "bending", "A", 0, branch)
            rows.append(dict(zip(names, (*who, *told), strict=True)))
    table.write(folder / "readings.csv", rows)


def two_designs() -> Front:
    """A front of two designs with a shape each."""
    models, points = [], []
    for number, xi in enumerate((0.0, 0.3)):
        settings = assignments([*synthetic_run.COARSE, f"morph.xi2={xi}"])
        shape = unloaded_shape(config.load(None, settings))
        models.append(shape.packed())
        group = "chosen" if number else "design"
        rows = [("ξ₂", f"{xi}"), ("Blocked force (N), surrogate", "3.00 ± 0.12")]
        points.append(FrontPoint(f"Design {number + 1}", xi, 2 + xi, group, rows, number))
    axes = Axis("COG offset (mm)", "mm", "COG offset"), Axis("Blocked force (N)", "N", "Force")
    return Front("Designs", *axes, points, ([0.0, 0.3], [2.0, 2.3]), models, 1, ["Two designs."])


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    for name in ("a", "b"):
        synthetic_run.write_result(folder / name, ["bend", HOSTILE])
    write_diagnosis(folder / "diagnosed")
    page = sources.build(sources.find([folder]))
    page.front = two_designs()
    written = folder / "report.html"
    written.write_text(html.rendered(page), encoding="utf-8")
    return written


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium.browser() as found:
        yield found


def opened(browser: Browser, file: Path, *, width: int = 1280, flat: bool = False) -> Opened:
    page = browser.new_page(viewport={"width": width, "height": 900})
    said = chromium.heard(page)
    if flat:
        page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(file.as_uri())
    page.wait_for_selector("html[data-ready]")
    return Opened(page, said)


@pytest.fixture(scope="module")
def seen(browser: Browser, file: Path) -> Opened:
    found = opened(browser, file)
    found.page.wait_for_selector("html[data-film]")
    return found


def test_it_says_no_error_and_asks_for_nothing(seen: Opened, file: Path) -> None:
    assert seen.said == chromium.Heard()
    assert file.stat().st_size < 1e6 * html.LARGEST_MB
    assert chromium.state(seen.page, "ready") == "webgl"
    # text of data is text
    assert seen.page.evaluate("window.stolen") is None
    assert HOSTILE in (seen.page.locator(".source").first.text_content() or "")


def test_only_its_own_scripts_run(browser: Browser, file: Path) -> None:
    page = browser.new_page()
    said = chromium.heard(page)
    text = file.read_text(encoding="utf-8")
    spoilt = file.with_name("spoilt.html")
    spoilt.write_text(text.replace("</body>", "<script>window.stolen = 1</script></body>"))
    page.goto(spoilt.as_uri())
    assert page.evaluate("window.stolen") is None
    assert "Content Security Policy" in said.errors[0]


def test_the_slider_goes_from_step_to_step(seen: Opened) -> None:
    page = seen.page
    slider = page.locator("#time")
    slider.focus()
    page.keyboard.press("Home")
    assert page.inner_text("#now") == "0 kPa"
    assert page.inner_text("#said") == f"loading, solved step 1 of {LAST + 1}"
    page.keyboard.press("ArrowRight")
    assert page.inner_text("#now") == "50 kPa"
    slider.evaluate("node => { node.value = 0.5; node.dispatchEvent(new Event('input')); }")
    assert page.inner_text("#now") == "25 kPa"
    assert "interpolated between the solved steps at 0 kPa and 50 kPa" in page.inner_text("#said")
    assert slider.get_attribute("aria-valuetext")


@pytest.mark.parametrize("width", [1280, 700, 390])
def test_the_slider_keeps_its_place_under_the_pointer(seen: Opened, width: int) -> None:
    page = seen.page
    page.set_viewport_size({"width": width, "height": 900})
    slider = page.locator("#time")
    boxes = []
    for value in (0, 0.5, 1, 2.35, LAST):
        slider.evaluate(
            "(node, v) => { node.value = v; node.dispatchEvent(new Event('input')); }", value
        )
        boxes.append(slider.bounding_box())
    page.set_viewport_size({"width": 1280, "height": 900})
    assert boxes[0]
    assert boxes == [boxes[0]] * len(boxes)


def test_no_table_is_cut_on_a_phone(seen: Opened) -> None:
    """A table fits into its box, or the box scrolls; the checks fit."""
    page = seen.page
    page.set_viewport_size({"width": 390, "height": 844})
    cut = page.evaluate("""() => {
      for (const each of document.querySelectorAll('details')) each.open = true;
      return [...document.querySelectorAll('table')].filter((table) => {
        const box = table.parentElement;
        const scrolls = box.classList.contains('wide') && !table.classList.contains('trust')
          && getComputedStyle(box).overflowX === 'auto';
        return !scrolls && box.scrollWidth > box.clientWidth;
      }).map((table) => table.innerText.slice(0, 60));
    }""")
    wide = page.evaluate("document.documentElement.scrollWidth")
    page.evaluate("for (const each of document.querySelectorAll('details')) each.open = false")
    page.set_viewport_size({"width": 1280, "height": 900})
    assert cut == []
    assert wide <= 390


def test_a_picture_and_a_video_are_saved(seen: Opened, tmp_path: Path) -> None:
    """The picture has the title, the scale and the shape; the video shows the shape move."""
    page = seen.page
    page.locator("#time").press("End")
    with page.expect_download() as loading:
        page.click("#picture")
    assert loading.value.suggested_filename == "Free_bending_a.png"
    loading.value.save_as(tmp_path / "picture.png")
    picture = plt.imread(tmp_path / "picture.png")
    height, width = picture.shape[:2]
    assert min(height, width) >= 900
    colours = np.unique((255 * picture[:, -width // 9 :, :3]).astype(int).reshape(-1, 3), axis=0)
    assert len(colours) > 200  # of the scale
    at = page.inner_text("#said")
    with page.expect_download(timeout=60_000) as recording:
        page.click("#video")
        expect(page.locator("#video")).to_have_text(
            re.compile(r"Stop \([3-9]\d %\)"), timeout=60_000
        )
        page.click("#video")  # which stops it
    film = tmp_path / recording.value.suggested_filename
    assert film.suffix in (".mp4", ".webm")
    recording.value.save_as(film)
    with av.open(str(film)) as container:
        # players of MP4 know H.264 alone
        codec = container.streams.video[0].codec_context.name
        assert film.suffix == (".mp4" if codec == "h264" else ".webm")
        frames = [f.to_ndarray(format="gray").astype(float) for f in container.decode(video=0)]
    assert len(frames) >= 10
    assert max(np.abs(frame - frames[0]).max() for frame in frames) > 50
    assert page.inner_text("#said") == at
    assert not seen.said.errors


def test_curves_and_the_slider_move_each_other(seen: Opened) -> None:
    page = seen.page
    chart = page.locator("#chart-0")
    page.locator("#time").press("Home")
    before = chart.locator(".now").first.get_attribute("cx")
    for _ in range(2):
        page.locator("#time").press("ArrowRight")
    assert chart.locator(".now").first.get_attribute("cx") != before
    # the other way: a click on the third point of the first curve
    page.locator("#time").press("Home")
    chart.locator("svg > .dot").nth(2).click(force=True)
    assert page.inner_text("#now") == "100 kPa"


def test_values_under_the_pointer(seen: Opened) -> None:
    page = seen.page
    page.locator("#chart-0 svg > .dot").nth(2).hover(force=True)
    tip = page.locator("#chart-0 .tip")
    assert "100 kPa" in tip.inner_text()
    assert re.search(r"a: .*50°", tip.inner_text())
    page.locator("#time").press("Home")
    page.locator("#time").press("ArrowRight")
    box = page.locator("#view canvas[tabindex]").bounding_box()
    assert box is not None
    place = {"x": 0.2 * box["width"], "y": box["height"] / 2}
    page.locator("#view canvas[tabindex]").hover(position=place, force=True)
    page.wait_for_selector("#probe:not([hidden])")
    assert re.fullmatch(r"finger: [\d.]+ mm", page.inner_text("#probe"))


def test_the_scale_marks_the_present_maximum(seen: Opened) -> None:
    page = seen.page
    at = "getComputedStyle(document.querySelector('#bar u')).getPropertyValue('--at')"
    page.locator("#time").press("Home")
    assert page.evaluate(at) == "0%"
    assert page.inner_text("#peak") == "largest now: 0 mm"
    for _ in range(4):  # the largest pressure
        page.locator("#time").press("ArrowRight")
    assert page.evaluate(at) == "100%"


def test_two_runs_side_by_side_and_their_section(seen: Opened) -> None:
    page = seen.page
    assert page.locator("#captions span").all_inner_texts() == [
        "Free bending, a",
        "Free bending, b",
    ]
    assert page.locator("#film img").count() == min(6, LAST + 1)
    whole = page.locator("#view").screenshot()
    page.click("#section")
    page.wait_for_timeout(300)
    assert page.locator("#view").screenshot() != whole
    page.click("#section")
    page.click("[data-scene='1']")
    page.wait_for_selector("#captions:not(:has(span))", state="attached")
    page.click("[data-scene='1']")
    page.wait_for_selector("#captions:has(span)", state="attached")


def test_pointing_at_the_front_shows_the_design(seen: Opened) -> None:
    page = seen.page
    assert page.inner_text("#design-name") == "Design 2"
    key = page.locator(".front .key span").all_inner_texts()
    assert key == ["front of the surrogate", "design computed", "chosen"]  # there is no original
    page.locator("#front-chart .point.design").hover(force=True)
    page.wait_for_selector("html[data-design='Design 1']")
    assert page.inner_text("#design-name") == "Design 1"
    assert "3.00 ± 0.12" in page.inner_text("#design-rows")
    page.locator("#front-chart .point.chosen").focus()
    page.wait_for_selector("html[data-design='Design 2']")


def error_bars(part: Locator) -> list[tuple[float, float, float]]:
    """Place in pixels, and ends by the vertical axis, of the error bars of a chart."""
    ticks = part.locator("text.tick.end").evaluate_all(
        "all => all.map((text) => [text.textContent.replace('−', '-'), text.getAttribute('y')])"
    )
    slope, offset = np.polyfit([float(y) - 4 for _, y in ticks], [float(t) for t, _ in ticks], 1)
    drawn = part.locator("path.bars-of").get_attribute("d") or ""
    ends = re.findall(r"M([\d.]+) ([\d.]+)V([\d.]+)", drawn)
    return [(float(at), *(slope * float(y) + offset for y in (a, b))) for at, a, b in ends]


def test_the_diagnosis_begins_with_the_answer_and_what_was_measured(
    seen: Opened, file: Path
) -> None:
    section = seen.page.locator("section.diagnosis")
    told = [section.locator(".answer").inner_text()]
    told += section.locator(".lines li").all_inner_texts()
    said = lines(DiagnosisFile.read(file.parent / "diagnosed"))
    assert told == [line.replace("`", "") for line in said]  # as code
    codes = section.locator(":is(.answer, .lines) code").all_inner_texts()
    assert codes == [code for line in said for code in line.split("`")[1::2]]
    assert told[0].startswith("Softening at large strain (yeoh): ")
    titles = section.locator("figure h3").all_inner_texts()
    assert titles == ["bending: tip angle"]
    key = section.locator("figure .key span").all_inner_texts()
    assert key == ["measured, ± 2 std", "as configured", "extended by yeoh", "nuisances fitted"]
    upper, lower = section.locator("figure .chart").all()
    assert upper.locator("path.line:not([d=''])").count() == 2
    assert upper.locator("path.band").count() == 0
    # bars of ± 2 × 0.5° at all 18 readings, at the same places above and below
    measured, left = (error_bars(part) for part in (upper, lower))
    assert [at for at, *_ in measured] == [at for at, *_ in left]
    assert len(left) == 18
    for low, high in ((low, high) for _, low, high in (*measured, *left)):
        assert high - low == pytest.approx(2.0, abs=0.3)  # a tenth of a pixel is up to 0.1°
    assert {round(high + low) for _, low, high in left} == {0}
    rms = "6.08 as configured, 6.08 nuisances fitted, 0 extended by yeoh; noise 0.5."
    assert section.locator("figure .note").inner_text().endswith(f"in °: {rms}")
    bars = section.locator(".bars text").all_text_contents()
    assert bars[:2] == ["yeoh", "0.90"]


def test_sentences_of_a_table_begin_below_their_heading(seen: Opened) -> None:
    """A short one, too; numbers end below theirs."""
    seen.page.evaluate("for (const each of document.querySelectorAll('details')) each.open = true")
    found = seen.page.evaluate("""() => [...document.querySelectorAll('.wide > table:not(.trust)')]
      .map((table) => [...table.rows].map((row) => [...row.cells].map((cell) =>
        [getComputedStyle(cell).textAlign, cell.innerText.length])))""")
    seen.page.evaluate("for (const each of document.querySelectorAll('details')) each.open = false")
    sides = set()
    for heading, *rows in found:
        for (side, _), *cells in zip(heading, *rows, strict=True):
            longest = max((length for _, length in cells), default=0)
            sides.add((side, longest > 23))
            assert {each for each, _ in cells} <= {side}
    assert (
        {("left", True), ("right", False)}
        <= sides
        <= {("left", True), ("right", False), ("left", False)}
    )


def test_no_probability_reads_one(tmp_path: Path) -> None:
    write_diagnosis(tmp_path / "diagnosed")
    file = tmp_path / "diagnosed" / DiagnosisFile.FILE
    said, bars = [], []
    for probability in ("0.9,", "0.9999,"):
        text = file.read_text(encoding="utf-8").replace(
            '"probability": 0.9,', f'"probability": {probability}'
        )
        (tmp_path / "other").mkdir(exist_ok=True)
        (tmp_path / "other" / file.name).write_text(text, encoding="utf-8")
        page = sources.build(sources.find([tmp_path / "other"]))
        said += [each.said for each in page.numbers]
        bars += [each for chart in page.diagnoses for each in chart.bars.series[0].said]
    assert said == ["probability 0.90", "probability > 0.99"]
    assert bars == ["0.90", "> 0.99"]


def test_every_measured_reading_is_drawn_however_many_there_are(
    browser: Browser, tmp_path: Path
) -> None:
    write_diagnosis(tmp_path / "diagnosed", 110)  # both ways: 220 readings
    page = sources.build(sources.find([tmp_path]))
    written = tmp_path / "report.html"
    written.write_text(html.rendered(page), encoding="utf-8")
    figures = opened(browser, written).page.locator("section.diagnosis figure")
    assert figures.count() == 1
    upper, lower = figures.locator(".chart").all()
    assert upper.locator("circle.dot").count() == 220
    assert float(upper.locator("circle.dot").first.get_attribute("r") or 9) < 3
    assert [len(error_bars(each)) for each in (upper, lower)] == [220, 220]
    # residuals lie on three lines: before the fit on two, and after it on one that both ways share
    assert lower.locator("circle.dot").count() == 3 * 110


def test_dark_and_light(seen: Opened) -> None:
    page = seen.page
    colour = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(colour)
    page.emulate_media(color_scheme="dark")
    page.wait_for_selector("html[data-theme=dark]")
    assert page.evaluate(colour) != light
    page.emulate_media(color_scheme="light")
    page.wait_for_selector("html[data-theme=light]")
    assert page.evaluate(colour) == light


def test_print(seen: Opened) -> None:
    page = seen.page
    page.wait_for_selector("#printed[src]", state="attached")
    page.emulate_media(media="print")
    assert page.locator("#printed").is_visible()
    assert not page.locator("#section").is_visible()
    printed = page.pdf(format="A4")
    page.emulate_media(media="screen")
    assert printed.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) >= 2


def test_a_phone(browser: Browser, file: Path) -> None:
    found = opened(browser, file, width=400)
    assert chromium.overflow_px(found.page) <= 0
    assert found.said == chromium.Heard()
    found.page.close()


def test_without_webgl_there_are_pictures_and_curves(browser: Browser, file: Path) -> None:
    page = opened(browser, file, flat=True).page
    assert chromium.state(page, "ready") == "flat"
    assert page.locator(".stills img").first.is_visible()
    assert page.locator("#chart-0 path.line").count() > 0
    page.locator("#time").press("Home")
    assert page.inner_text("#now") == "0 kPa"
    page.close()


def test_a_front_without_shapes() -> None:
    assert front.front(front.Loop()) is None
