"""Who is let in: 400 for another host, 403 for another origin or without the token."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from dolfingrip import config
from dolfingrip.explore import guard, server, space
from dolfingrip.explore.library import Library
from dolfingrip.explore.session import Session

PORT = 8765
HERE = f"http://127.0.0.1:{PORT}"
COOKIE = f"dolfingrip-{PORT}"
TAB = f"ws://127.0.0.1:{PORT}/tab"
TOKEN = "a" * 43


@pytest.fixture
def client(tmp_path: Path) -> Iterator[TestClient]:
    designed = space.of_results([], {}, None, ["finger.length_mm=38", "finger.bellows=2"], [])
    session = Session(designed, Library(designed), tmp_path)
    app = server.application(session, TOKEN, "127.0.0.1", PORT)
    with TestClient(app, base_url=HERE, follow_redirects=False) as found:
        yield found


def test_the_address_that_is_printed(client: TestClient) -> None:
    assert client.get("/").status_code == 403
    assert client.get("/?token=another").status_code == 403
    let_in = client.get(f"/?token={TOKEN}")
    assert let_in.status_code == 303
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
            ('{"do": "fly"}', "do = fly: allowed: show, solve, cancel, rig, plan"),
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


def test_nobody_else_reads_the_token(tmp_path: Path) -> None:
    found = guard.token(tmp_path)
    file = tmp_path / "token"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert guard.token(tmp_path) == found  # of a server that is started again
    file.chmod(0o644)
    assert guard.token(tmp_path) != found


def test_a_port_that_is_taken() -> None:
    taken = server.bound("127.0.0.1", 0)
    port = taken.getsockname()[1]
    taken.listen()
    with pytest.raises(config.ConfigError, match=f"--port {port}: in use; allowed: another"):
        server.bound("127.0.0.1", port)
    taken.close()
