"""The studio's server: who may ask, what is served, how large a message may be."""

from __future__ import annotations

import json
import queue
import struct
import threading
import time

import pytest

import gemrender
from gemrender.cli.program import run
from gemrender.studio.desk import Desk
from gemrender.studio.serve import listen

testclient = pytest.importorskip("starlette.testclient")

from starlette.websockets import WebSocketDisconnect  # noqa: E402

from gemrender.studio.app import HEADERS, make_app  # noqa: E402

TOKEN = "the-token"
ORIGIN = "http://127.0.0.1:8123"
#: Long enough for a machine that has much else to do [s].
PATIENCE = 120.0


@pytest.fixture(scope="module")
def desk():
    return Desk([gemrender.load_stone("inoue-3")])


@pytest.fixture
def client(desk):
    with testclient.TestClient(make_app(desk, TOKEN, 8123), base_url=ORIGIN) as made:
        yield made


def live(client, token=TOKEN, **headers):
    address = f"ws://127.0.0.1:8123/{token}/live"
    return client.websocket_connect(address, headers={"origin": ORIGIN, **headers})


def header_of(message):
    length = struct.unpack_from("<I", message)[0]
    return json.loads(message[4 : 4 + length])


def received(socket):
    """The next message; what never comes fails the test, as the test client itself waits for ever."""
    got = queue.SimpleQueue()
    threading.Thread(target=lambda: got.put(socket.receive_bytes()), daemon=True).start()
    return got.get(timeout=PATIENCE)


def until(socket, *types):
    """The first message of one of these types."""
    end, seen = time.monotonic() + PATIENCE, []
    while time.monotonic() < end:
        header = header_of(received(socket))
        if header["type"] in types:
            return header
        seen.append(header["type"])
    raise AssertionError(f"none of {types} among {seen}")


def test_the_page_and_its_files_are_served_with_a_strict_policy(client):
    page = client.get(f"/{TOKEN}/")
    assert page.status_code == 200
    assert "{{" not in page.text
    for name in ("main.js", "tracer.js", "page.css", "studio.css"):
        assert f"assets/{name}" in page.text
        assert client.get(f"/{TOKEN}/assets/{name}").status_code == 200
    for name, value in HEADERS.items():
        assert page.headers[name] == value
    policy = page.headers["content-security-policy"]
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy
    assert "http" not in policy


@pytest.mark.parametrize("path", ["/", "/wrong/", "/the-toke/", "//", "/wrong/assets/main.js", "/wrong/live"])
def test_without_the_token_nothing_is_served(client, path):
    answer = client.get(path)
    assert answer.status_code == 403
    assert "script" not in answer.text


@pytest.mark.parametrize(
    "path",
    [
        "assets/../app.py", "assets/..%2fapp.py", "assets/%2e%2e%2f%2e%2e%2fcli%2fstudio.py",
        "assets//etc/passwd", "assets/%2fetc%2fpasswd", "assets/app.py", "assets/", "../app.py",
        "assets/main.js/..", "assets/index.html", "assets/widget.js",
    ],
)  # fmt: skip
def test_no_path_leads_out_of_the_pages_own_files(client, path):
    assert client.get(f"/{TOKEN}/{path}").status_code in (403, 404)


@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example"}, {"host": "evil.example:8123"}, {"host": "127.0.0.1:9"},
        {"host": "127.0.0.1"}, {"host": ""}, {"origin": "http://evil.example"}, {"origin": "null"},
        {"origin": "http://localhost:8123"}, {"origin": "https://127.0.0.1:8123"}, {"origin": "http://127.0.0.1:9"},
    ],
)  # fmt: skip
def test_another_host_or_origin_is_refused(client, headers):
    assert client.get(f"/{TOKEN}/", headers=headers).status_code == 403
    with pytest.raises(WebSocketDisconnect) as closed, live(client, **headers):
        pass
    assert closed.value.code == 1008


def test_a_websocket_needs_token_and_origin(client):
    with pytest.raises(WebSocketDisconnect), live(client, token="wrong"):
        pass
    with pytest.raises(WebSocketDisconnect), client.websocket_connect(f"ws://127.0.0.1:8123/{TOKEN}/live"):
        pass


def test_beyond_loopback_hosts_are_known_by_number_only(desk):
    app = make_app(desk, TOKEN, 8123, "0.0.0.0")
    with testclient.TestClient(app, base_url=ORIGIN) as client:
        for host, status in (("192.168.1.7:8123", 200), ("[fe80::1]:8123", 200), ("evil.example:8123", 403),
                             ("192.168.1.7:9", 403)):  # fmt: skip
            assert client.get(f"/{TOKEN}/", headers={"host": host}).status_code == status


def test_a_page_opens_a_stone_and_has_its_frames_and_two_pages_do_not_disturb_each_other(client):
    with live(client) as one, live(client) as other:
        for socket, name in ((one, "inoue-3"), (other, "tolkowsky")):
            socket.send_text(json.dumps({"type": "open", "bundled": name}))
        opened = [until(socket, "opened")["stones"][0] for socket in (one, other)]
        for number, (socket, stone) in enumerate(zip((one, other), opened, strict=True)):
            socket.send_text(json.dumps({"type": "state", "number": number, "cut": stone["cut"]}))
        for number, (socket, name) in enumerate(((one, "inoue-3"), (other, "tolkowsky"))):
            frame = until(socket, "frame", "refused")
            assert frame["number"] == number
            assert frame["score"]["average"] == pytest.approx(gemrender.score(name).average, abs=0.1)


def test_a_dropped_file_is_opened_and_what_is_no_stone_is_told(client):
    def send(socket, name, data):
        head = json.dumps({"type": "drop", "name": name}).encode()
        socket.send_bytes(struct.pack("<I", len(head)) + head + data)

    with live(client) as socket:
        send(socket, "my.toml", b'[cut]\nfamily = "oval"\n')
        assert until(socket, "opened", "failed")["stones"][0]["name"] == "my"
        send(socket, "bad.asc", b"nothing")
        assert "bad.asc" in until(socket, "failed")["why"]


@pytest.mark.parametrize(
    "message", ["", "no json", '{"type": "delete"}', '{"type": "open", "key": "x"}', '{"type": "save"}']
)
def test_nonsense_is_answered_in_one_line(client, message):
    with live(client) as socket:
        socket.send_text(message)
        assert "\n" not in until(socket, "failed")["why"]


def test_an_oversized_message_ends_the_connection(client, monkeypatch):
    monkeypatch.setattr("gemrender.studio.app.MOST_MESSAGE", 1000)
    with live(client) as socket:
        socket.send_bytes(bytes(1001))
        with pytest.raises(WebSocketDisconnect) as closed:
            socket.receive_bytes()
    assert closed.value.code == 1009


def test_a_port_that_is_taken_is_told():
    with listen("127.0.0.1", 0) as taken:
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(gemrender.InputError, match="port"):
            listen("127.0.0.1", port)
    with pytest.raises(gemrender.InputError, match="host"):
        listen("no such host", 0)
    with pytest.raises(gemrender.InputError, match="65535"):
        listen("127.0.0.1", 70_000)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no-such-stone"], "no-such-stone: no such file"),
        (["--port", "x"], "--port = 'x'"),
        (["--port", "70000"], "--port = 70000"),
        (["--host", "no such host"], "--host = 'no such host'"),
    ],
)
def test_the_command_refuses_in_one_line(capsys, arguments, words):
    assert run(["studio", "--no-browser", *arguments]) == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1
    assert words in told[0]
