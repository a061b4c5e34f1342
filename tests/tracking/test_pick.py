"""``dolfingrip track --pick``: dots that are clicked on the first frame in the browser."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pandas as pd
import pytest
from starlette.testclient import TestClient
from support import chromium
from support.filmed import Filmed, arc, write
from typer.testing import CliRunner

from dolfingrip.cli.commands import app
from dolfingrip.config import ConfigError
from dolfingrip.serving.listening import bound
from dolfingrip.tracking.pick import application, clicked

PORT = 8766
HERE = f"http://127.0.0.1:{PORT}"
TOKEN = "a" * 43
CLICKED = [[10.0, 20.0], [30.5, 40.25], [50.0, 60.0]]


@pytest.fixture
def client() -> Iterator[tuple[TestClient, list[np.ndarray]]]:
    taken: list[np.ndarray] = []
    image = np.full((80, 120, 3), 200, np.uint8)
    served = application(image, "<bend>.mp4", TOKEN, PORT, taken.append)
    with TestClient(served, base_url=HERE) as page:
        yield page, taken


def test_the_page_and_its_dots(client: tuple[TestClient, list[np.ndarray]]) -> None:
    page, taken = client
    assert page.get("/").status_code == 403
    page.get(f"/?token={TOKEN}")
    shown = page.get("/")
    assert shown.status_code == 200
    assert "Dots of &lt;bend&gt;.mp4" in shown.text
    assert "data:image/png;base64," in shown.text
    assert shown.headers["content-security-policy"].startswith(
        "default-src 'none'; script-src 'sha"
    )
    foreign = page.post(
        "/dots", content=json.dumps(CLICKED), headers={"origin": "http://evil.example"}
    )
    assert foreign.status_code == 403
    assert not taken
    assert (
        page.post("/dots", content=json.dumps(CLICKED), headers={"origin": HERE}).status_code == 200
    )
    np.testing.assert_array_equal(taken[0], CLICKED)


@pytest.mark.parametrize(
    "sent",
    ["{", "[]", "[[1, 2], [3, 4]]", "[[1, 2], [3, 4], [5]]", "[[1, 2], [3, 4], [500, 6]]",
     '[[1, 2], [3, 4], ["x", 6]]', "[[1, 2], [3, 4], [NaN, 6]]", "[[1, 2], [3, 4], [-9, 6]]",
     "[" * 50_000, '{"a": 1}', json.dumps([[1, 2]] * 201)],
)  # fmt: skip
def test_what_no_page_sends(client: tuple[TestClient, list[np.ndarray]], sent: str) -> None:
    page, taken = client
    page.get(f"/?token={TOKEN}")
    refused = page.post("/dots", content=sent, headers={"origin": HERE})
    assert refused.status_code == 422
    assert refused.text == "dots: allowed: 3 to 200 places in the frame"
    too_long = page.post("/dots", content="1" * 200_000, headers={"origin": HERE})
    assert too_long.status_code == 413
    assert not taken


def test_dots_are_clicked_in_a_browser() -> None:
    """Also where the picture is shown smaller; a click on a ring takes it away."""
    image = np.full((1200, 3000, 3), 200, np.uint8)
    told: list[str] = []
    places: list[np.ndarray] = []

    def serve() -> None:
        places.append(clicked(image, "wide.jpg", bound("127.0.0.1", 0), TOKEN, told.append))

    server = threading.Thread(target=serve)
    server.start()
    while not told:
        time.sleep(0.05)
    with chromium.browser() as found:
        page = found.new_page(viewport={"width": 900, "height": 700})
        said = chromium.heard(page)
        page.goto(told[0])
        shown = page.locator("#image")
        box = shown.bounding_box()
        assert box is not None
        assert box["width"] < 900
        assert page.locator("#done").is_disabled()
        for u, v in ((0.1, 0.2), (0.5, 0.5), (0.7, 0.3), (0.9, 0.8)):
            page.mouse.click(box["x"] + u * box["width"], box["y"] + v * box["height"])
        page.get_by_label("dot 3: take it away").click()
        assert page.locator("#said").inner_text() == "3 dots"
        page.locator("#done").click()
        page.get_by_text("These dots are followed").wait_for()
        assert not said.errors
    server.join()
    expected = np.array([[0.1, 0.2], [0.5, 0.5], [0.9, 0.8]]) * [3000, 1200] - 0.5
    np.testing.assert_allclose(places[0], expected, atol=3.5)


def send(address: str, places_px: np.ndarray) -> None:
    """Do what the page does: take the token's cookie, and send the dots."""
    url = urlsplit(address)
    assert url.hostname
    door = HTTPConnection(url.hostname, url.port or 80, timeout=30)
    door.request("GET", f"/?{url.query}")
    first = door.getresponse()
    first.read()
    cookie = (first.getheader("set-cookie") or "").partition(";")[0]
    told = {"Cookie": cookie, "Origin": f"http://{url.hostname}:{url.port}"}
    door.request("POST", "/dots", json.dumps(places_px.tolist()), told)
    assert door.getresponse().status == 200
    door.close()


def test_clicked_dots_are_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Four of six, and another red thing that nobody clicked."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    camera = Filmed()
    bends = np.linspace(0.0, 40.0, 12)
    write(tmp_path / "film.mp4", [camera.frame(arc(bend), seed=i) for i, bend in enumerate(bends)])
    lines = [f"{t:.2f},{p:.3f}" for t, p in zip(np.arange(12) / 30, bends, strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(["time_s,pressure_kPa", *lines]))
    chosen = camera.pixels(arc(0.0)[[0, 2, 4, 5]]) + np.array([1.5, -1.0])
    workers = []

    def browser(uri: str) -> bool:
        page = Path(urlsplit(uri).path).read_text(encoding="utf-8")
        address = page.partition('href="')[2].partition('"')[0].replace("&amp;", "&")
        workers.append(threading.Thread(target=send, args=(address, chosen)))
        workers[0].start()
        return True

    monkeypatch.setattr("webbrowser.open", browser)
    asked = ["track", "film.mp4", "--log", "log.csv", "--shift", "0", "--pick", "--in-front", "10",
             "--set", "finger.length_mm=62", "--no-overlay", "-o", "out"]  # fmt: skip
    monkeypatch.chdir(tmp_path)
    found = CliRunner().invoke(app, asked)
    workers[0].join()
    assert found.exception is None, found.exception
    told = " ".join(f"{u:.1f},{v:.1f}" for u, v in chosen)
    assert f'the same again: --points "{told}"' in " ".join(found.output.split())
    frames = pd.read_csv(tmp_path / "out" / "film_frames.csv")
    assert "marker_4_x_mm" in frames
    assert "marker_5_x_mm" not in frames
    true = np.array([-arc(bend)[-1, 0] for bend in bends])
    assert np.abs(frames["marker_4_x_mm"] - true).max() < 1.0


@pytest.mark.parametrize(("told", "said"), [(("--points", "1,2 3,4 5,6"), "without --points"),
                                            (("--tags", "4x4"), "without --tags")])  # fmt: skip
def test_dots_are_told_in_one_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, told: tuple[str, ...], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "film.mp4", [Filmed().frame(arc(bend)) for bend in (0.0, 10.0)])
    (tmp_path / "log.csv").write_text("time_s,pressure_kPa\n0,0\n1,10\n")
    told = ("--log", "log.csv", *told)
    found = CliRunner().invoke(app, ["track", "film.mp4", "--pick", *told, "-o", "out"])
    assert isinstance(found.exception, ConfigError)
    assert str(found.exception) == f"--pick: allowed: {said}"
