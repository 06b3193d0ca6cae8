"""The page that runs a robot: its size, its start, the script's time for a frame, its kernels beside Python's.

python benchmarks/robot_page.py [--quick] [--robots panda ur5e puma560]

Chromium is led headless over its own protocol. "frame" is the script's part of a picture with all views open, ghosts
and an action before each: kernels, views, the items of the scene, the calls into WebGL; not what the graphics processor
does with them, nor the browser's layout. "start" is the time from the page's first statement to its first picture asked
for, of a later load: unpacking and compiling kernels, meshes, shaders, views. A first load starts the browser's
graphics too.
"""

from __future__ import annotations

import argparse
import gzip
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.page import Session, show  # noqa: E402
from tests.page.browser import Browser  # noqa: E402

FRAMES = """new Promise(async (done) => {
  const app = window.mafsil, taken = [];
  for (const { card } of app.updates) card.open = true;
  for (let k = 0; k < %d; k++) {
    app.store.do("set_joint", { joint: 1, value: app.store.state.q[1] + 0.002 }, { gesture: true });
    const begin = performance.now();
    app.frame(begin);
    taken.push(performance.now() - begin);
    await new Promise((next) => setTimeout(next));
  }
  done(taken);
})"""
CALLS = """(() => {
  const { kernels, settings } = window.mafsil.store.arm, { q, push } = window.mafsil.store.state, rest = q.map(() => 0);
  const T = Array.from(kernels.forward_kinematics(q)[0]), effort = settings.effort.map((x) => x ?? Infinity);
  const inputs = {
    forward_kinematics: [q], link_poses: [q], jacobian_body: [q], gravity_torque: [q],
    closed_loop: [[...q, ...rest], [...q, ...rest, ...rest], settings.gains, [settings.step], T, effort, push],
  };
  return Object.fromEntries(Object.entries(inputs).map(([name, given]) => {
    let best = Infinity;
    for (let repeat = 0; repeat < 5; repeat++) {
      const begin = performance.now();
      for (let k = 0; k < %d; k++) kernels[name](...given);
      best = Math.min(best, (performance.now() - begin) * 1000 / %d);
    }
    return [name, best];
  }));
})()"""


def main() -> None:
    """Print one table for each robot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--robots", nargs="+", default=["panda", "ur5e", "puma560"])
    arguments = parser.parse_args()
    frames, calls = (60, 4000) if arguments.quick else (300, 40_000)
    print(machine())
    with tempfile.TemporaryDirectory() as name, Browser(Path(name), (1166, 700)) as browser:
        for robot in arguments.robots:
            _measure(browser, Path(name), robot, frames, calls)


def _measure(browser: Browser, folder: Path, robot: str, frames: int, calls: int) -> None:
    path = show(robot, language="en").write(folder / f"{robot}.html")
    starts: list[float] = []
    for _ in range(4):
        browser.load(path)
        starts.append(float(browser.ask("mafsil.timing.start")))
    taken = np.array(browser.ask(FRAMES % frames))
    html = path.read_bytes()
    print(f"\n{robot}: {len(html) / 1e3:.0f} kB ({len(gzip.compress(html)) / 1e3:.0f} kB compressed), target 300 kB")
    print(f"  start  {starts[0]:.0f} ms first, {min(starts[1:]):.0f} ms then; target 100 ms")
    print(f"  frame  median {np.median(taken):.2f} ms, p95 {np.percentile(taken, 95):.2f} ms of script; target 4 ms")
    kernels = Session(robot).arm.kernels
    for kernel, microseconds in browser.ask(CALLS % (calls, calls)).items():
        if kernel in kernels:
            print(f"  {kernel:20} {microseconds:6.2f} us a call in the page, inputs copied in")


if __name__ == "__main__":
    main()
