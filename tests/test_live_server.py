"""The live server to those who shall use it, to those who shall not, and to Ctrl-C."""

import http.client
import signal
import socket
import subprocess

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from tests.reference.commands import environment, started_as
from tests.reference.live_server import SECONDS, ask, served, told


@pytest.fixture(scope="module")
def live():
    with served() as running:
        yield running


def answer(live, method: str = "GET", path: str | None = None, body: str | None = None, **headers: str | None):
    """Status, headers and text that a request gets; a header that is None is left out."""
    connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=SECONDS)
    connection.putrequest(method, live.path if path is None else path, skip_host=True)
    sent = {"Host": f"127.0.0.1:{live.port}"} | headers | ({} if body is None else {"Content-Length": str(len(body))})
    for name, value in sent.items():
        if value is not None:
            connection.putheader(name, value)
    connection.endheaders(None if body is None else body.encode())
    response = connection.getresponse()
    found = response.status, response.headers, response.read().decode()
    connection.close()
    return found


def test_the_page_is_whole_and_may_load_nothing(live):
    status, headers, text = answer(live)
    assert status == 200 and headers["Content-Type"] == "text/html; charset=utf-8"
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; ") and "unsafe" not in policy and "frame-ancestors 'none'" in policy
    assert headers["Cache-Control"] == "no-store" and headers["Referrer-Policy"] == "no-referrer"
    assert "Access-Control-Allow-Origin" not in headers
    assert "uPlot" in text and live.path.strip("/") not in text


def test_both_names_of_this_machine_will_do(live):
    assert answer(live, Host=f"localhost:{live.port}")[0] == 200


@pytest.mark.parametrize("path", ["/", "/live", "/wrong/", "/wrong/live", "//", "/{token}", "/{token}/?a", "/{token}x/",
                                  "/{token}/../", "/x/{token}/", "/{token}/favicon.ico"])  # fmt: skip
def test_without_the_token_everything_is_forbidden(live, path):
    status, _, text = answer(live, path=path.replace("{token}", live.path.strip("/")))
    assert status == 403 and text == "403 Forbidden\n"


@pytest.mark.parametrize("host", [None, "", "evil.example", "127.0.0.1", "127.0.0.1:1", "evil.example:{port}"])
def test_another_name_of_the_host_is_forbidden(live, host):
    """Which a site has whose name was made to resolve to this machine."""
    assert answer(live, Host=None if host is None else host.replace("{port}", str(live.port)))[0] == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1"])
def test_pages_of_another_origin_are_forbidden(live, origin):
    origin = origin.replace("{port}", str(live.port))
    assert answer(live, Origin=origin)[0] == 403
    with pytest.raises(InvalidStatus) as refused:
        live.connected(origin)
    assert refused.value.response.status_code == 403


def test_a_connection_needs_an_origin_and_the_token(live):
    for origin, path in ((None, None), ("", "/live"), ("", "/wrong/live")):
        with pytest.raises(InvalidStatus) as refused:
            live.connected(origin, path)
        assert refused.value.response.status_code == 403


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH", "TRACE"])
def test_there_is_nothing_but_get(live, method):
    assert answer(live, method)[0] == 405


def test_what_has_a_body_or_is_no_request_gets_no_page(live):
    with pytest.raises((http.client.BadStatusLine, ConnectionError)):
        answer(live, "POST", body="speed=1")
    with socket.create_connection(("127.0.0.1", live.port), timeout=SECONDS) as door:
        door.sendall(b"\x16\x03\x01\x02\x00\r\n\r\n")
        assert b"200" not in door.recv(1000)
    assert answer(live)[0] == 200


def test_it_listens_on_one_loopback_address_alone(live):
    """127.0.0.2 is this machine as well: who listens everywhere answers there."""
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.2", live.port), timeout=SECONDS)


def test_nonsense_is_told_so_and_ends_nothing(live):
    with live.connected() as viewer:
        for text in ("", "{", "[]", "7", '{"more": 1}', '{"pace": {"slowness": 0.5}}', '{"pace": {"slowness": 1e9}}',
                     '{"values": 1}', '{"values": {"speed_rpm": 1}}', '{"frame": "yes"}', b"\xff", b"\x00",
                     '{"values": {"speed_rpm": NaN}}'):  # fmt: skip
            viewer.send(text)
            assert told(viewer, "refused")
        ask(viewer, frame=True)
        assert told(viewer, "frame")["outer"]
    with live.connected() as viewer, pytest.raises(ConnectionClosed):
        viewer.send("x" * 100_000)
        while True:
            viewer.recv(timeout=SECONDS)
    assert answer(live)[0] == 200


def test_what_one_viewer_changes_all_see_and_what_is_refused_changes_nothing(live):
    with live.connected() as one, live.connected() as other:
        values = told(one, "bearing")["values"]
        told(other, "bearing")
        ask(one, values=values | {"radial_load_N": -1.0})
        assert "operation.radial_load_N = -1.0" in told(one, "refused")
        ask(one, values=values | {"radial_load_N": 700.0})
        for viewer in (one, other):
            assert told(viewer, "bearing")["values"] == values | {"radial_load_N": 700.0}
            ask(viewer, frame=True)
            assert sum(told(viewer, "frame")["outer"]) > 700.0
        ask(other, pace={"slowness": 200.0, "playing": False})
        assert told(one, "pace") == {"slowness": 200.0, "playing": False}
    with live.connected() as late:  # finds what is played, and where it stands
        assert told(late, "bearing")["values"]["radial_load_N"] == 700.0
        assert told(late, "pace")["playing"] is False
        assert sum(told(late, "frame")["outer"]) > 700.0


def test_a_paused_run_goes_on_by_steps_and_stands_while_nobody_asks(live):
    """A step is a twentieth of a second of the page: 1 ms at 1/50."""
    with live.connected() as viewer:
        ask(viewer, pace={"slowness": 50.0, "playing": False}, values=told(viewer, "bearing")["values"], frame=True)
        told(viewer, "bearing")  # of the new run
        assert told(viewer, "frame")["time"] == 0.0
        for time in (1.0, 2.0):
            ask(viewer, step=True, frame=True)
            assert told(viewer, "frame")["time"] == pytest.approx(time)
        ask(viewer, pace={"slowness": 50.0, "playing": True}, frame=True)
        last = told(viewer, "frame")["time"]
    with live.connected() as late:
        assert told(late, "frame")["time"] == last
        ask(late, frame=True)
        assert told(late, "frame")["time"] > last


def test_ctrl_c_ends_it_with_viewers_watching():
    process = subprocess.Popen(
        started_as("run-live"), env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        address = process.stdout.readline().split()[1]
        port, token = int(address.split(":")[2].split("/")[0]), address.split("/")[3]
        with socket.create_connection(("127.0.0.1", port), timeout=SECONDS) as viewer:
            request = (
                f"GET /{token}/live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\n"
                "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
            )
            viewer.sendall(request.encode())
            assert viewer.recv(12) == b"HTTP/1.1 101"
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    assert process.returncode == 130 and error == "interrupted\n"
    assert len(token) > 20
