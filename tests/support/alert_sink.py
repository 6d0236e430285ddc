"""A server that alerts reach, as a service in the network would: each message with the path that it was sent to."""

import json
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

POSTS = "import sys, urllib.request; urllib.request.urlopen(sys.argv[1], sys.stdin.read().encode(), 20)"


@dataclass
class AlertSink:
    """What has arrived, in its order."""

    address: str
    received: list[tuple[str, str]] = field(default_factory=list)

    def settings(self, file: Path, escalate_after_min: float) -> Path:
        """Write a file of alerts whose people listen here: first the address for the first call, later the others."""
        command = [[sys.executable, "-c", POSTS, f"{self.address}{path}"] for path in ("/desk", "/others")]
        file.write_text(
            f"command = {json.dumps(command[0])}\n"
            f"[escalate]\nafter_min = {escalate_after_min}\ncommand = {json.dumps(command[1])}\n",
            encoding="utf-8",
        )
        return file

    def of(self, path: str) -> list[str]:
        return [text for to, text in self.received if to == path]


@contextmanager
def alert_sink() -> Iterator[AlertSink]:
    received: list[tuple[str, str]] = []

    class Takes(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"])).decode()
            received.append((self.path, body))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Takes) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield AlertSink(f"http://127.0.0.1:{server.server_address[1]}", received)
        finally:
            server.shutdown()
            thread.join()
