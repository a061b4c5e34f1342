"""Who is let in: 400 for another host, 403 for another origin or without the token."""

from __future__ import annotations

import asyncio
import math
import socket
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import uvicorn
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect
from typer.testing import CliRunner

from dolfingrip import config
from dolfingrip.cli.commands import app
from dolfingrip.explore import describe, server, space
from dolfingrip.explore.library import Library
from dolfingrip.explore.session import Session
from dolfingrip.serving import guard, listening
from dolfingrip.serving.guard import Handover
from dolfingrip.serving.policy import ServingPolicy

PORT = 8765
HERE = f"http://127.0.0.1:{PORT}"
COOKIE = f"dolfingrip-{PORT}"
TAB = f"ws://127.0.0.1:{PORT}/tab"
TOKEN = "a" * 43


@pytest.fixture
def client(tmp_path: Path) -> Iterator[TestClient]:
    designed = space.of_results([], None, {"finger.length_mm": 38, "finger.bellows": 2}, [])
    session = Session(designed, Library(designed), tmp_path)
    app = server.application(session, TOKEN, "127.0.0.1", PORT)
    with TestClient(app, base_url=HERE, follow_redirects=False) as found:
        yield found


def test_the_address_that_is_printed(client: TestClient) -> None:
    assert client.get("/").status_code == 403
    assert client.get("/?token=another").status_code == 403
    let_in = client.get(f"/?token={TOKEN}")
    assert let_in.status_code == 200
    assert '<meta http-equiv="refresh" content="0;url=/">' in let_in.text
    assert TOKEN not in let_in.text
    cookie = let_in.headers["set-cookie"]
    assert cookie.startswith(f"{COOKIE}={TOKEN};")
    assert {"HttpOnly", "SameSite=strict", "Path=/"} <= set(cookie.split("; "))
    page = client.get("/")
    assert page.status_code == 200
    policy = page.headers["content-security-policy"]
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "connect-src 'self'" in policy
    assert page.headers["x-frame-options"] == "DENY"


@pytest.mark.parametrize("host", ["evil.example", f"evil.example:{PORT}", "127.0.0.1.evil.example"])
def test_another_host(client: TestClient, host: str) -> None:
    client.cookies.set(COOKIE, TOKEN)
    assert client.get("/", headers={"host": host}).status_code == 400


@pytest.mark.parametrize("origin", ["http://evil.example", f"https://127.0.0.1:{PORT}", "null",
                                    "http://127.0.0.1:1"])  # fmt: skip
def test_another_origin(client: TestClient, origin: str) -> None:
    client.cookies.set(COOKIE, TOKEN)
    assert client.get("/", headers={"origin": origin}).status_code == 403
    with (
        pytest.raises(WebSocketDisconnect) as refused,
        client.websocket_connect(TAB, headers={"origin": origin}),
    ):
        pass
    assert refused.value.code == 1008


def test_a_request_that_changes_something_must_tell_its_origin(client: TestClient) -> None:
    client.cookies.set(COOKIE, TOKEN)
    assert client.post("/").status_code == 403
    with pytest.raises(WebSocketDisconnect), client.websocket_connect(TAB):
        pass


def test_a_tab(client: TestClient) -> None:
    headers = {"origin": HERE}
    with (
        pytest.raises(WebSocketDisconnect),
        client.websocket_connect(TAB, headers=headers),
    ):
        pass  # without the token
    client.cookies.set(COOKIE, TOKEN)
    with client.websocket_connect(TAB, headers=headers) as tab:
        assert tab.receive_json()["counts"] == {"bending": 0, "blocked_force": 0}
        for sent, said in (
            ("{", "message: not JSON"),
            ("[]", "message: allowed: a JSON object"),
            ('{"do": "fly"}', "do = fly: allowed: show, solve, cancel, follow, rig, plan"),
            ('{"do": "follow", "view": "bending", "curve": {"rise_s": 0, "hold_s": 1}}',
             "rise_s = 0: allowed: 0.001 to 3600 s"),
            ('{"do": "follow", "view": "bending", "curve": {"rise_s": 1}}',
             "hold_s = None: allowed: a number"),
            ('{"do": "follow", "view": "bending", "curve": {"rise_s": 1, "hold_s": 1}}',
             "free bending: not solved; allowed: solved, of one cavity, above 0 kPa"),
            ('{"do": "show", "view": "x"}', "view = x: allowed: bending, blocked_force, grasp"),
            ('{"do": "show", "view": "bending", "inputs": {"morph.xi1": 9}}',
             "morph.xi1 = 9: allowed: -0.2 to 1"),
            ('{"do": "show", "view": "bending", "inputs": {"morph.xi1": "0"}}',
             "morph.xi1 = 0: allowed: a number"),
            ('{"do": "show", "view": "grasp", "gripper": {"pose": "fist"}}',
             'gripper.pose = "fist": allowed: scoop, pinch, claw'),
            ('{"do": "rig", "view": "bending", "answers": {"experiments": ["flight"]}}',
             "experiments = flight: allowed: bending, blocked_force, coupon"),
        ):  # fmt: skip
            tab.send_text(sent)
            assert tab.receive_json()["text"] == said


BAD = {
    '{"do": "show", "id": NaN}': "message: number \"NaN\": allowed: finite",
    '{"do": "show", "id": 1e999}': "message: number \"1e999\": allowed: finite",
    f'{{"do": "show", "id": {"9" * 400}}}': f'message: number "{"9" * 59}…: allowed: finite',
    f'{{"do": "show", "id": {"9" * 5000}}}': f'message: number "{"9" * 59}…: allowed: finite',
    '{"do": "show", "view": "\\ud800"}': "message: half a surrogate pair; allowed: whole",
    '{"do": "show", "inputs": {"\\udfff": 1}}': "message: half a surrogate pair; allowed: whole",
    '{"do": "rig", "view": "bending", "answers": {"experiments": ["coupon"], "protocol": "abc"}}':
        'protocol = "abc": allowed: a table',
    '{"a":' * 15_000: "message: nested too deeply",
    "[" * 90_000: "message: nested too deeply",
}  # fmt: skip
"""What no page sends, and what is answered."""


def test_what_no_page_sends(client: TestClient, capfd: pytest.CaptureFixture[str]) -> None:
    """Each is answered by an error, and the tab lives on; the terminal says nothing."""
    client.cookies.set(COOKIE, TOKEN)
    with client.websocket_connect(TAB, headers={"origin": HERE}) as tab:
        tab.receive_json()
        for sent, said in BAD.items():
            tab.send_text(sent)
            answer = tab.receive_json()
            assert answer["is"] == "error"
            assert answer["text"].startswith(said), answer["text"][:200]
        tab.send_bytes(b"\xff")
        assert tab.receive_json()["text"] == "message: not JSON"
        tab.send_text('{"do": "rig", "view": "bending", "answers": {"experiments": ["bending"]}}')
        made = tab.receive_json()
        assert made["is"] == "rig", made
    assert capfd.readouterr() == ("", "")


def test_what_fails_unexpectedly(
    client: TestClient, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def fails(*_: object) -> None:
        raise RuntimeError("no such mesh")

    def unsendable(*_: object) -> dict[str, float]:
        return {"angle_deg": math.nan}

    shown = '{"do": "show", "id": 3, "view": "bending"}'
    client.cookies.set(COOKIE, TOKEN)
    with client.websocket_connect(TAB, headers={"origin": HERE}) as tab:
        tab.receive_json()
        monkeypatch.setattr(describe, "described", fails)
        tab.send_text(shown)
        assert tab.receive_json() == {
            "is": "error", "about": "show", "id": 3, "text": "RuntimeError: no such mesh",
        }  # fmt: skip
        monkeypatch.setattr(describe, "described", unsendable)
        tab.send_text(shown)
        assert tab.receive_json()["text"].startswith("ValueError: ")
    assert capfd.readouterr() == ("", "")


def test_cookies_of_other_servers(client: TestClient) -> None:
    """Browsers send them, too, as they share cookies between ports."""
    assert client.get("/", headers={"cookie": f"a/b=1; {COOKIE}={TOKEN}"}).status_code == 200
    assert client.get("/", headers={"cookie": "a/b=1; \x01=\x02; =; ;;"}).status_code == 403
    assert client.get("/", headers={"cookie": f"{COOKIE}="}).status_code == 403


def test_a_fresh_token_is_handed_over_by_a_private_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    results = tmp_path / "results"
    handed = Handover.of(results)
    assert handed.before() is None
    handed.write(f"{HERE}/?token={TOKEN}")
    assert stat.S_IMODE(handed.file.stat().st_mode) == 0o600
    assert stat.S_IMODE(handed.file.parent.stat().st_mode) == 0o700
    assert handed.before() == (PORT, TOKEN)
    assert Handover.of(results).before() == (PORT, TOKEN)
    assert Handover.of(tmp_path / "others").before() is None
    handed.write(f"{HERE}/?token={TOKEN[::-1]}b")
    assert len(list(handed.file.parent.iterdir())) == 1
    assert not results.exists()


def test_a_restart_needs_a_server_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    asked = CliRunner().invoke(app, ["explore", "--restart", "-o", str(tmp_path / "out")])
    assert isinstance(asked.exception, config.ConfigError)
    assert str(asked.exception) == f"--restart: no server had {tmp_path}/out; allowed: without it"


async def _half_open(
    server: uvicorn.Server, door: socket.socket, opened: int
) -> tuple[bytes, list[bytes]]:
    """A whole request's answer while many others stay half open, and what became of these."""
    serving = asyncio.create_task(server.serve(sockets=[door]))
    port = door.getsockname()[1]
    begun = []
    for _ in range(opened):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b"GET / HTTP/1.1\r\nHo")
        begun.append((reader, writer))
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    answer = await asyncio.wait_for(reader.readline(), 10)
    writer.close()
    ended = []
    for reader, writer in begun:
        try:
            ended.append(await asyncio.wait_for(reader.read(), 10))
        except ConnectionError:
            ended.append(b"")
        writer.close()
    server.should_exit = True
    await serving
    return answer, ended


def test_half_open_requests_are_few_and_short() -> None:
    policy = ServingPolicy(half_open=8, request_s=0.5)

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await guard.PlainTextResponse("let in")(scope, receive, send)

    door = listening.bound("127.0.0.1", 0)
    door.listen()
    settings = listening.server_settings(app, policy)
    settings.lifespan = "off"
    opened = 4 * ServingPolicy().half_open
    answer, ended = asyncio.run(_half_open(uvicorn.Server(settings), door, opened))
    assert answer == b"HTTP/1.1 200 OK\r\n"
    assert set(ended) == {b""}


def test_a_port_that_is_taken() -> None:
    taken = listening.bound("127.0.0.1", 0)
    port = taken.getsockname()[1]
    taken.listen()
    with pytest.raises(config.ConfigError, match=f"--port {port}: in use; allowed: another"):
        listening.bound("127.0.0.1", port)
    taken.close()


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "127.0.0.1", "gripper.lab"])
def test_an_address_that_can_be_opened_is_told(host: str) -> None:
    told = listening.reachable(host)
    assert told not in ("", "0.0.0.0", "::")
    assert host in ("0.0.0.0", "::") or told == host
