"""A headless Chromium led over the DevTools protocol: real pointer and key events, pictures, requests, downloads.

The protocol is JSON over a pair of pipes (`--remote-debugging-pipe`): no library and no socket is needed.
"""

from __future__ import annotations

import base64
import json
import os
import select
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.page.node import needed

FLAGS = (
    "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-extensions", "--hide-scrollbars", "--remote-debugging-pipe",
)  # fmt: skip
PATIENCE = 60.0


class Browser:
    """One window.

    Args:
        folder: for the profile and for downloads.
        size: of the window [pixels].
        flags: more of them, such as `--disable-gpu`.
    """

    def __init__(self, folder: Path, size: tuple[int, int] = (1280, 860), flags: tuple[str, ...] = ()) -> None:
        program = needed("chromium", "chromium-browser", "google-chrome")
        to_read, self._to = os.pipe()
        self._from, to_write = os.pipe()
        words = [program, *FLAGS, *flags, f"--user-data-dir={folder / 'profile'}", f"--window-size={size[0]},{size[1]}"]
        words.append("about:blank")

        def connected() -> None:
            # The protocol's own numbers: 3 is read from, 4 is written to.
            first, second = os.dup(to_read), os.dup(to_write)
            os.dup2(first, 3)
            os.dup2(second, 4)

        self._process = subprocess.Popen(
            words,
            preexec_fn=connected,  # noqa: PLW1509 - before any thread of the tests
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self.downloads = folder / "downloads"
        self.downloads.mkdir(exist_ok=True)
        self.requests: list[str] = []
        self.errors: list[str] = []
        self._rest, self._count, self._session = b"", 0, ""
        targets = self._call("Target.getTargets")["targetInfos"]
        target = next(one["targetId"] for one in targets if one["type"] == "page")
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self._call(f"{domain}.enable")
        self._call("Performance.enable", timeDomain="threadTicks")
        self._call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.downloads))
        self.resize(*size)

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait(timeout=20)
        os.close(self._to)
        os.close(self._from)

    def resize(self, width: int, height: int, *, phone: bool = False, scheme: str = "light", media: str = "") -> None:
        """Size of the page, as on a phone or not, light or dark, on a screen or as `print`."""
        self._call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self._call("Emulation.setEmulatedMedia", features=features, media=media)

    def load(
        self, path: Path | str, ending: str = "", drawn: str = "window.mafsil && window.mafsil.timing.frames > 0"
    ) -> None:
        """Open a file, or an address, and wait until its script has drawn, which an expression tells."""
        # The answer to a navigation may come before the page has changed; what is kept for a reload is left behind.
        self.ask("window.left = true; try { history.replaceState(null, ''); } catch {} history.replaceState = () => {}")
        self._call("Page.navigate", url=path + ending if isinstance(path, str) else path.as_uri() + ending)
        self.wait(f"!window.left && {drawn}")

    def reload(self) -> None:
        """The same page once more, as a reader does."""
        self.ask("window.left = true")
        self._call("Page.reload")
        self.wait("!window.left && window.mafsil && window.mafsil.timing.frames > 0")

    def wait(self, condition: str) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.ask(f"Boolean({condition})"):
            if time.monotonic() > end:
                raise TimeoutError(f"{condition}; errors: {self.errors}")
            time.sleep(0.03)

    def ask(self, expression: str) -> Any:
        """The value of an expression in the page."""
        found = self._call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise RuntimeError(json.dumps(found["exceptionDetails"])[:2000])
        return found["result"].get("value")

    def violations(self) -> list[Any]:
        """What axe-core finds wrong with what is seen, as rules with the first element of each."""
        axe = pytest.importorskip("axe_core_python").__file__
        self.ask(f"{Path(axe).with_name('axe.min.js').read_text('utf-8')}; 0")
        found = "found.violations.map(one => [one.id, one.nodes.length, one.nodes[0].html.slice(0, 150)])"
        return self.ask(f"axe.run({{iframes: false}}).then(found => {found})")

    def small_targets(self) -> list[str]:
        """What can be pressed and is less than 24 pixels wide or high, WCAG 2.2, 2.5.8; a field with its label."""
        pressed = "button, input, select, summary, a[href], textarea, [role=slider]"
        return self.ask(
            f"[...document.querySelectorAll('{pressed}')].filter(e => e.checkVisibility()).filter(e => {{"
            " const b = (e.closest('label') ?? e).getBoundingClientRect(); return b.width < 23.5 || b.height < 23.5;"
            " }).map(e => e.outerHTML.slice(0, 120))"
        )

    def settled_box(self, selector: str) -> tuple[float, float, float, float]:
        """`box` once two drawn pictures agree on it: what was opened just before may still push others down."""
        seen = self.box(selector)
        while True:
            self.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            before, seen = seen, self.box(selector)
            if seen == before:
                return seen

    def box(self, selector: str) -> tuple[float, float, float, float]:
        """Left, top, width and height of an element, brought into view [pixels]."""
        found = self.ask(
            f"(e => {{ e.scrollIntoView({{block: 'nearest'}}); const b = e.getBoundingClientRect();"
            f" return [b.left, b.top, b.width, b.height]; }})(document.querySelector({json.dumps(selector)}))"
        )
        return (found[0], found[1], found[2], found[3])

    def mouse(self, kind: str, x: float, y: float, *, buttons: int = 0, modifiers: int = 0) -> None:
        """A pointer event: `mousePressed`, `mouseMoved`, `mouseReleased`; modifiers as of `key`."""
        button = "none" if kind == "mouseMoved" and not buttons else "left"
        event = {"type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "modifiers": modifiers}
        self._call("Input.dispatchMouseEvent", **event, clickCount=1)

    def click(self, selector: str) -> None:
        """Press and release in the middle of an element, once it no longer moves."""
        left, top, width, height = self.settled_box(selector)
        x, y = left + width / 2, top + height / 2
        self.mouse("mousePressed", x, y, buttons=1)
        self.mouse("mouseReleased", x, y)

    def drag(self, start: tuple[float, float], end: tuple[float, float], steps: int = 8, *, modifiers: int = 0) -> None:
        """Press at one place, move in steps, release at another; modifiers as of `key`."""
        self.mouse("mousePressed", *start, buttons=1, modifiers=modifiers)
        for k in range(1, steps + 1):
            x, y = (a + (b - a) * k / steps for a, b in zip(start, end, strict=True))
            self.mouse("mouseMoved", x, y, buttons=1, modifiers=modifiers)
        self.mouse("mouseReleased", *end, modifiers=modifiers)

    def key(self, name: str, *, modifiers: int = 0) -> None:
        """Press a key and let it go; modifiers: 2 control, 8 shift."""
        code = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Tab": 9}.get(name, 0)
        for kind in ("keyDown", "keyUp"):
            event = {"type": kind, "key": name, "code": name, "windowsVirtualKeyCode": code, "modifiers": modifiers}
            self._call("Input.dispatchKeyEvent", **event)

    def memory(self) -> int:
        """Bytes that the script's objects take, after collecting what nobody uses."""
        self._call("HeapProfiler.collectGarbage")
        return int(self._call("Runtime.getHeapUsage")["usedSize"])

    def counted(self, name: str) -> int:
        """How many there are of what the browser counts, such as `JSEventListeners` or `Nodes`."""
        found = self._call("Performance.getMetrics")["metrics"]
        return next(int(one["value"]) for one in found if one["name"] == name)

    def script_time(self) -> float:
        """Processor time that the scripts of the page have taken [s], however busy the machine is."""
        found = self._call("Performance.getMetrics")["metrics"]
        return next(float(one["value"]) for one in found if one["name"] == "ScriptDuration")

    def picture(self, path: Path) -> None:
        """Write what is seen."""
        path.write_bytes(base64.b64decode(self._call("Page.captureScreenshot", format="png")["data"]))

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": method, "params": parameters}
        if self._session and not method.startswith("Browser."):
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + PATIENCE
        while True:
            answer = self._next(end)
            if answer.get("id") == self._count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def _note(self, event: Mapping[str, Any]) -> None:
        details = event.get("params", {})
        if event.get("method") == "Network.requestWillBeSent":
            self.requests.append(details["request"]["url"])
        elif event.get("method") == "Runtime.exceptionThrown":
            self.errors.append(json.dumps(details["exceptionDetails"])[:2000])
        elif event.get("method") == "Log.entryAdded" and details["entry"]["level"] == "error":
            self.errors.append(details["entry"]["text"])

    def _next(self, end: float) -> dict[str, Any]:
        while b"\0" not in self._rest:
            if not select.select([self._from], [], [], max(0.0, end - time.monotonic()))[0]:
                raise TimeoutError("the browser does not answer")
            part = os.read(self._from, 1 << 20)
            if not part:
                raise ConnectionError("the browser has ended")
            self._rest += part
        text, _, self._rest = self._rest.partition(b"\0")
        return json.loads(text)
