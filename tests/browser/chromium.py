"""A headless Chromium driven over the DevTools protocol's pipe, with Python's own library alone."""

import base64
import json
import os
import select
import shutil
import struct
import subprocess
import tempfile
import time
import zlib


def program():
    """The browser's path, or None."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Chromium:
    def __init__(self, width=1100, height=900):
        self._profile = tempfile.mkdtemp(prefix="viscobar-chromium-")
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()

        def connect():  # the protocol's pipe is at descriptors 3 and 4
            low = [os.dup2(to_browser, 103), os.dup2(from_browser, 104)]
            for source, goal in zip(low, (3, 4)):
                os.dup2(source, goal, inheritable=True)

        self._process = subprocess.Popen(
            [program(), "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
             "--force-device-scale-factor=1", "--force-color-profile=srgb", "--remote-debugging-pipe", "--no-first-run",
             "--disable-background-networking", "--disable-extensions", f"--user-data-dir={self._profile}",
             f"--window-size={width},{height}", "about:blank"],
            preexec_fn=connect, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self._buffer, self._count, self._size, self._scripts = b"", 0, (width, height), True
        self._session = None
        self.messages, self.requests = [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")
        self.resize(width, height)

    def close(self):
        try:
            self._session = None
            self.call("Browser.close")
            self._process.wait(10)
        except Exception:
            self._process.kill()
            self._process.wait()
        shutil.rmtree(self._profile, ignore_errors=True)

    def call(self, method, **parameters):
        self._count += 1
        request = {"id": self._count, "method": method, "params": parameters}
        if self._session:
            request["sessionId"] = self._session
        os.write(self._out, json.dumps(request).encode() + b"\0")
        return self._wait(lambda message: message.get("id") == self._count, method)

    def _wait(self, wanted, what, seconds=60):
        end = time.monotonic() + seconds
        while True:
            while b"\0" in self._buffer:
                text, self._buffer = self._buffer.split(b"\0", 1)
                message = json.loads(text)
                self._note(message)
                if wanted(message):
                    if "error" in message:
                        raise RuntimeError(f"{what}: {message['error']}")
                    return message.get("result", message)
            if not select.select([self._in], [], [], max(0.0, end - time.monotonic()))[0]:
                raise TimeoutError(what)
            block = os.read(self._in, 1 << 20)
            if not block:
                raise RuntimeError(f"{what}: the browser is gone")
            self._buffer += block

    def _note(self, message):
        parameters = message.get("params", {})
        if message.get("method") == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.messages.append(details.get("exception", {}).get("description") or details["text"])
        elif message.get("method") == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            self.messages.append(str([argument.get("value") for argument in parameters["args"]]))
        elif message.get("method") == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning"):
            self.messages.append(parameters["entry"]["text"])
        elif message.get("method") == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])

    def open(self, path, scripts=True):
        """Loads a file; `messages` and `requests` are then those of this page."""
        self.messages, self.requests = [], []
        self._scripts = scripts
        self.call("Emulation.setScriptExecutionDisabled", value=not scripts)
        self.call("Page.navigate", url="file://" + os.path.abspath(path))
        self._wait(lambda message: message.get("method") == "Page.loadEventFired", "load")
        self.settle()

    def settle(self):
        """Two frames: what was asked for is drawn."""
        if self._scripts:
            self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"].get("exception", {}).get("description", expression))
        return result["result"].get("value")

    def resize(self, width, height):
        self._size = (width, height)
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def media(self, kind="screen", scheme="light"):
        self.call("Emulation.setEmulatedMedia", media=kind, features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.settle()

    def key(self, key, code=None):
        number = {" ": 32, "Enter": 13, "Tab": 9, "Home": 36, "End": 35, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39,
                  "ArrowDown": 40, "PageUp": 33, "PageDown": 34}.get(key, ord(key.upper()) if len(key) == 1 else 0)
        text = {"Enter": "\r"}.get(key, key if len(key) == 1 else "")
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, windowsVirtualKeyCode=number,
                      **({"text": text} if kind == "keyDown" and text else {}))
        self.settle()

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def move(self, x, y):
        self.mouse("mouseMoved", x, y)
        self.settle()

    def drag(self, begin, end):
        self.mouse("mouseMoved", *begin)
        self.mouse("mousePressed", *begin, button="left", buttons=1, clickCount=1)
        for part in (0.3, 0.7, 1.0):
            self.mouse("mouseMoved", *(a + part * (b - a) for a, b in zip(begin, end)), button="left", buttons=1)
        self.mouse("mouseReleased", *end, button="left", clickCount=1)
        self.settle()

    def click(self, x, y):
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
        self.mouse("mouseReleased", x, y, button="left", clickCount=1)
        self.settle()

    def pixel(self, x, y):
        """(red, green, blue) of a place in view."""
        left, top = self.evaluate("[scrollX, scrollY]")  # a clip is a part of the page
        clip = {"x": int(x + left), "y": int(y + top), "width": 1, "height": 1, "scale": 1}
        data = self.call("Page.captureScreenshot", format="png", clip=clip)["data"]
        return Png(base64.b64decode(data)).at(0, 0)

    def screenshot(self, path, whole=False):
        """A PNG of what is in view, or of the whole page, as a file."""
        if whole:
            width, height = self._size
            self.resize(width, int(self.evaluate("document.documentElement.scrollHeight")) + 1)
            self.settle()
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        if whole:
            self.resize(width, height)
        with open(path, "wb") as file:
            file.write(data)


class Png:
    """Pixels of a PNG of 8 bits a channel, RGB or RGBA, as browsers write them."""

    def __init__(self, data):
        at, parts = 8, []
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at:at + 8])
            if kind == b"IHDR":
                self.width, self.height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
                assert depth == 8 and colour in (2, 6)
                self.channels = 3 if colour == 2 else 4
            elif kind == b"IDAT":
                parts.append(data[at + 8:at + 8 + size])
            at += size + 12
        self._rows = self._unfiltered(zlib.decompress(b"".join(parts)))

    def _unfiltered(self, raw):
        n, length = self.channels, self.width * self.channels
        rows, above = [], bytearray(length)
        for j in range(self.height):
            kind = raw[j * (length + 1)]
            row = bytearray(raw[j * (length + 1) + 1:(j + 1) * (length + 1)])
            if kind == 1:
                for i in range(n, length):
                    row[i] = (row[i] + row[i - n]) & 255
            elif kind == 2:
                row = bytearray((a + b) & 255 for a, b in zip(row, above))
            elif kind == 3:
                for i in range(length):
                    row[i] = (row[i] + ((row[i - n] if i >= n else 0) + above[i]) // 2) & 255
            elif kind == 4:
                for i in range(length):
                    a, b, c = (row[i - n] if i >= n else 0), above[i], (above[i - n] if i >= n else 0)
                    p = a + b - c
                    pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
                    row[i] = (row[i] + (a if pa <= pb and pa <= pc else b if pb <= pc else c)) & 255
            rows.append(row)
            above = row
        return rows

    def at(self, x, y):
        """(red, green, blue)"""
        i = int(x) * self.channels
        return tuple(self._rows[int(y)][i:i + 3])
