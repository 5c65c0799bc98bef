# SPDX-License-Identifier: BSD-3-Clause
"""Chromium without a screen, driven by its DevTools protocol (https://chromedevtools.github.io/devtools-protocol)."""

import base64
import json
import shutil
import subprocess
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import websocket

#: [s] longest wait for anything; a busy machine needs some
PATIENCE = 60
FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]
FLAGS += [
    "--disable-extensions",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--remote-debugging-port=0",
]
FLAGS += ["--remote-allow-origins=*", "--window-size=1280,720", "--hide-scrollbars"]


class Tab:
    """One page. `evaluate` runs JavaScript in it; `requests` are the addresses that it asked for."""

    def __init__(self, target):
        self.id = target["id"]
        self.requests, self.errors = [], []
        self._socket = websocket.create_connection(target["webSocketDebuggerUrl"], timeout=PATIENCE)
        self._n_calls = 0
        for domain in ("Network", "Runtime", "Page"):
            self.call(f"{domain}.enable")
        self.call(
            "Emulation.setDeviceMetricsOverride", width=1280, height=720, deviceScaleFactor=1, mobile=False
        )

    def call(self, method, **parameters):
        """Result of a method of the protocol."""
        self._n_calls += 1
        self._socket.send(json.dumps({"id": self._n_calls, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._socket.recv())
            if message.get("id") == self._n_calls:
                assert "error" not in message, (method, message["error"])
                return message["result"]
            self._note(message)

    def _note(self, message):
        told = message.get("params", {})
        if message["method"] == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])
        elif message["method"] == "Network.webSocketCreated":
            self.requests.append(told["url"])
        elif message["method"] == "Runtime.exceptionThrown":
            self.errors.append(told["exceptionDetails"])

    def open(self, address):
        self.call("Page.navigate", url=address)

    def evaluate(self, expression):
        """Value of an expression in JavaScript; a promise is awaited."""
        done = self.call(
            "Runtime.evaluate",
            expression=expression,
            returnByValue=True,
            awaitPromise=True,
            userGesture=True,
        )
        assert "exceptionDetails" not in done, (expression, done["exceptionDetails"])
        return done["result"].get("value")

    def wait_for(self, expression):
        """First value of an expression that counts as true; AssertionError with what the page shows if none comes."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            value = self.evaluate(expression)
            if value or value == {}:  # an element comes as an empty object
                return value
            time.sleep(0.1)
        shown = self.evaluate("document.body.innerText")
        raise AssertionError(f"{expression} stayed false; the page shows:\n{shown}")

    def text(self, selector):
        """Text of the element that a CSS selector finds."""
        return self.evaluate(f"document.querySelector({selector!r})?.innerText ?? null")

    def set(self, selector, value):
        """Gives an input another value, as the user does by typing or by dragging."""
        self.evaluate(
            f"(() => {{ const e = document.querySelector({selector!r}); e.value = {json.dumps(str(value))};"
            "e.dispatchEvent(new Event('input', {bubbles: true}));"
            "e.dispatchEvent(new Event('change', {bubbles: true})); })()"
        )

    def click(self, selector):
        self.evaluate(f"document.querySelector({selector!r}).click()")

    def press(self, key):
        """Presses a key, such as ArrowRight or Tab, where the focus is."""
        code = {"ArrowRight": 39, "ArrowLeft": 37, "Tab": 9, "Enter": 13}[key]
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def screenshot(self):
        """What the tab shows, PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def close(self):
        self.call("Page.close")
        self._socket.close()


class Browser:
    """A running Chromium."""

    def __init__(self, port):
        self._port = port

    def new_tab(self, address="about:blank"):
        """A new tab, which opens an address."""
        request = urllib.request.Request(f"http://127.0.0.1:{self._port}/json/new?about:blank", method="PUT")
        with urllib.request.urlopen(request, timeout=PATIENCE) as reply:
            tab = Tab(json.load(reply))
        tab.open(address)
        return tab


@contextmanager
def chromium():
    """A Chromium for a `with` block."""
    with TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [shutil.which("chromium"), *FLAGS, f"--user-data-dir={profile}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            yield Browser(_port_of(process, Path(profile) / "DevToolsActivePort"))
        finally:
            process.terminate()
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _port_of(process, file):
    """Port of the DevTools, which Chromium writes into a file of its profile."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        assert process.poll() is None, "chromium ended at once"
        if file.exists() and "\n" in file.read_text():
            return int(file.read_text().split("\n")[0])
        time.sleep(0.05)
    raise AssertionError("chromium did not open its DevTools")
