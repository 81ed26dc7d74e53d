"""The studio in notebooks without one: what goes through the widget's comm, and the page within its frame."""

from __future__ import annotations

import base64
import contextlib
import json
import queue
import re
import subprocess
import sys

import comm
import pytest
from refusals import refused
from solids import star_prism

import gemrender
from gemrender.studio import assets
from gemrender.studio.desk import Desk
from gemrender.studio.protocol import unpacked

pytest.importorskip("anywidget")

#: Long enough for a machine that has much else to do [s].
PATIENCE = 120.0
#: Nothing comes for so long [s].
SILENCE = 0.3


class Notebook(comm.base_comm.BaseComm):
    """The other end of a widget's comm."""

    def publish_msg(self, msg_type, data=None, metadata=None, buffers=None, **keys):
        if not hasattr(self, "told"):
            self.told = queue.Queue()
        if data and data.get("method") == "custom":
            self.told.put((data["content"], buffers))

    def send_to_kernel(self, content, *buffers):
        data = {"method": "custom", "content": content}
        self.handle_msg({"content": {"data": data}, "buffers": list(buffers)})

    def until(self, kind, view="a"):
        """The first message of this type for a view, as the page has it."""
        while True:
            content, (buffer,) = self.told.get(timeout=PATIENCE)
            if content["view"] != view:
                continue
            if content["type"] == kind:
                return buffer
            if content["type"] == "message" and (header := unpacked(bytes(buffer))[0])["type"] == kind:
                return header


@pytest.fixture
def studio(monkeypatch):
    monkeypatch.setattr(comm, "create_comm", Notebook)
    made = gemrender.Studio("inoue-3", height=500)
    yield made
    made.close()


def ask(studio, view="a", **message):
    studio.comm.send_to_kernel({"view": view, "type": "message", "text": json.dumps(message)})


def test_a_view_gets_the_page_and_what_it_shows_is_the_widgets_stone_and_score(studio):
    scores = queue.Queue()
    studio.observe(lambda change: scores.put(change.new), "score")
    studio.comm.send_to_kernel({"view": "a", "type": "begin"})
    assert bytes(studio.comm.until("page")).startswith(b"<!DOCTYPE html>")
    key = Desk([studio.stone]).told()["shelf"][0]["key"]
    ask(studio, type="open", key=key)
    opened = studio.comm.until("opened")["stones"][0]
    cut = {**opened["cut"], "values": {**opened["cut"]["values"], "table": 58.0}}
    ask(studio, type="state", number=1, cut=cut, name="mine")
    frame = studio.comm.until("frame")
    score = scores.get(timeout=PATIENCE)
    assert studio.stone.name == "mine"
    assert studio.stone.cut.values()["table"] == 58.0
    assert score.average == frame["score"]["average"]


def test_a_file_is_dropped_through_the_comm_as_a_buffer(studio):
    studio.comm.send_to_kernel({"view": "a", "type": "begin"})
    head = json.dumps({"type": "drop", "name": "my.toml"}).encode()
    message = len(head).to_bytes(4, "little") + head + b'[cut]\nfamily = "oval"\n'
    studio.comm.send_to_kernel({"view": "a", "type": "message"}, memoryview(message))
    assert studio.comm.until("opened")["stones"][0]["name"] == "my"


def test_a_stone_that_is_given_is_shown_by_every_view(studio):
    for view in ("a", "b"):
        studio.comm.send_to_kernel({"view": view, "type": "begin"})
    studio.stone = "tolkowsky"
    for view in ("a", "b"):
        assert studio.comm.until("opened", view)["stones"][0]["name"] == studio.stone.name
    studio.comm.send_to_kernel({"view": "c", "type": "begin"})
    page = bytes(studio.comm.until("page", "c")).decode()
    told = json.loads(
        re.search(r'<script [^>]*type="application/json"[^>]*>(.*?)</script>', page, re.DOTALL)[1]
    )
    assert [of["name"] for of in told["shelf"]] == [studio.stone.name]
    refused(lambda: setattr(studio, "stone", star_prism()), "not convex")
    refused(lambda: setattr(studio, "stone", "no-such-stone"), "no-such-stone")


@pytest.mark.parametrize("content", [None, [], {}, {"view": 1}, {"view": "a", "type": "x"}, {"view": "?"}])
def test_nonsense_through_the_comm_does_nothing(studio, content):
    studio.comm.send_to_kernel(content)
    assert studio.comm.told.empty()


def test_views_that_are_gone_are_worked_for_no_more(studio):
    for number in range(12):
        studio.comm.send_to_kernel({"view": str(number), "type": "begin"})
    studio.comm.send_to_kernel({"view": "11", "type": "end"})
    for number in range(12):
        ask(studio, view=str(number), type="open", bundled="inoue-3")
    answered = set()
    with contextlib.suppress(queue.Empty):
        while True:
            content, _ = studio.comm.told.get(timeout=PATIENCE if len(answered) < 7 else SILENCE)
            if content["type"] == "message":
                answered.add(content["view"])
    assert answered == {str(number) for number in range(4, 11)}


def test_the_page_in_a_frame_has_all_its_files_in_it_and_may_load_no_others():
    page = assets.embedded_page(Desk([gemrender.load_stone("inoue-3")]).told()).decode()
    addresses = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert len(addresses) > 8
    assert all(address.startswith("data:") for address in addresses)
    nonce, policy = (
        re.search(r'<script type="importmap" nonce="([\w-]+)"', page)[1],
        re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)[1],
    )
    assert policy.startswith(f"default-src 'none'; script-src 'nonce-{nonce}' data:;")
    assert "http" not in policy
    assert "unsafe" not in policy
    modules = json.loads(re.search(r'<script type="importmap"[^>]*>(.*?)</script>', page)[1])["imports"]
    for address in modules.values():
        text = base64.b64decode(address.partition(",")[2]).decode()
        assert {
            f"gemrender/{name}" for name in re.findall(r"from 'gemrender/([\w.]+)'", text)
        } <= modules.keys()
        assert "from './" not in text


def test_without_anywidget_one_line_names_the_cure():
    code = (
        "import sys; sys.modules['anywidget'] = None; import gemrender\n"
        "try: gemrender.Studio('inoue-3')\n"
        "except gemrender.BackendError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout == (
        "the studio in notebooks needs anywidget; to get it: pip install 'gemrender[widget]'\n"
    ), done.stderr
