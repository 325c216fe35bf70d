"""A headless Chromium behind the DevTools protocol over pipes, which needs no other package."""

import itertools
import json
import os
import shutil
import subprocess

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--remote-debugging-pipe"]
KEYS = {"Enter": (13, "\r"), "Tab": (9, ""), "ArrowLeft": (37, ""), "ArrowRight": (39, ""), "ArrowDown": (40, ""), "End": (35, "")}


class Page:
    """A page in a window of a width; `messages` has what the console and the log said, and exceptions."""

    def __init__(self, profile):
        (self.theirs, write), (read, answers) = os.pipe(), os.pipe()

        def as_files_3_and_4():
            # Copies first, lest one take the place of the other.
            ends = [os.dup(self.theirs), os.dup(answers)]
            for number, end in zip((3, 4), [os.dup2(end, end + 20) for end in ends]):
                os.dup2(end, number)

        command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", "about:blank"]
        self.process = subprocess.Popen(command, close_fds=False, preexec_fn=as_files_3_and_4, stderr=subprocess.DEVNULL)
        os.close(self.theirs)
        os.close(answers)
        self.write, self.read = os.fdopen(write, "wb"), os.fdopen(read, "rb")
        self.numbers, self.session, self.messages, self.loaded, self.rest = itertools.count(1), None, [], False, b""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def receive(self):
        while b"\0" not in self.rest:
            more = os.read(self.read.fileno(), 1 << 16)
            assert more, "the browser ended"
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        message = json.loads(message)
        method = message.get("method", "")
        self.loaded |= method == "Page.loadEventFired"
        if method in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
            self.messages.append(message["params"])
        if method == "Network.requestWillBeSent" and not message["params"]["request"]["url"].startswith(("file:", "data:", "blob:")):
            self.messages.append(message["params"]["request"]["url"])
        return message

    def call(self, method, **parameters):
        number = next(self.numbers)
        message = {"id": number, "method": method, "params": parameters} | ({"sessionId": self.session} if self.session else {})
        self.write.write(json.dumps(message).encode() + b"\0")
        self.write.flush()
        while (answer := self.receive()).get("id") != number:
            pass
        assert "error" not in answer, answer
        return answer["result"]

    def open(self, path, width, address=""):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        self.messages, self.loaded = [], False
        self.call("Page.navigate", url=path.as_uri() + address)
        while not self.loaded:
            self.receive()

    def media(self, media, scheme="light"):
        self.call("Emulation.setEmulatedMedia", media=media, features=[{"name": "prefers-color-scheme", "value": scheme}])

    def run(self, script):
        """The value of an expression, of a promise what it is kept with."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def press(self, key):
        code, text = KEYS[key]
        about = {"key": key, "code": key, "windowsVirtualKeyCode": code, "text": text}
        self.call("Input.dispatchKeyEvent", type="keyDown", **about)
        self.call("Input.dispatchKeyEvent", type="keyUp", **about)

    def point(self, x, y):
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)

    def close(self):
        self.process.terminate()
        self.process.wait()
        self.write.close()
        self.read.close()
