"""The page that runs a robot: its size, its start, the script's time for a frame, drawing without a graphics processor.

python benchmarks/robot_page.py [--quick] [--robots panda ur5e puma560]

Chromium is led headless over its own protocol. A frame is the script's part of a picture with all views open: kernels,
views, the items of the scene, the calls into WebGL; not what the graphics processor does with them, nor the browser's
layout. "sliding" has an action before each and all ghosts; "loop" lets 16 ms pass in the closed loop, with ten seconds
of all joints and their goals in the plot. "drawing" is one whole picture made by software, until its last pixel is
there, at the half size that the page takes where there is no graphics processor. All are the least median of some
blocks, for the machine may be shared. "start" is the time from the page's first statement to its first picture asked
for, of a later load: unpacking and compiling kernels, meshes, shaders, views. A first load starts the browser's
graphics too, which an empty canvas waits for as well: the line below the machine's says how long.
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

from benchmarks.stopwatch import ONCE, machine  # noqa: E402
from mafsil.page import Session, show  # noqa: E402
from tests.page.browser import Browser  # noqa: E402

FRAMES = """new Promise(async (done) => {
  const app = window.mafsil, { store } = app, taken = [], loop = %s;
  for (const { card } of app.updates) Object.assign(card, { open: true, hidden: false });
  if (loop) {
    store.do("loop", { closed: true });
    store.do("push", { wrench: [0, 0, 0, 0, 15, 5] });
    document.getElementById("plot-values").click();
    const { update } = app.updates.find(({ view }) => view.name === "plot");
    for (let k = 0; k < 620; k++) {
      store.do("simulate", { ticks: 16 }, { gesture: true });
      store.open = true;
      update();
    }
  }
  const joint = store.arm.settings.n - 1;
  for (let k = 0; k < %d; k++) {
    const begin = performance.now();
    if (loop) { store.do("simulate", { ticks: 16 }, { gesture: true }); store.open = true; }
    else store.do("set_joint", { joint, value: store.state.q[joint] + 0.0005 }, { gesture: true });
    app.frame(begin);
    taken.push(performance.now() - begin);
    await new Promise((next) => setTimeout(next));
  }
  done(taken);
})"""
DRAWING = """(() => {
  const { stage, store } = window.mafsil, { gl } = stage.renderer, pixel = new Uint8Array(4), taken = [];
  store.show({ ghosts: %s });
  for (let k = 0; k < %d; k++) {
    const begin = performance.now();
    stage.paint();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    taken.push(performance.now() - begin);
  }
  const { canvas, width, height, named } = stage;
  return { taken, size: [canvas.width, canvas.height], shown: [width, height], ghosts: named.length };
})()"""
GRAPHICS = """(() => {
  const begin = performance.now();
  const gl = document.createElement("canvas").getContext("webgl2");
  gl.clear(gl.COLOR_BUFFER_BIT);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  return performance.now() - begin;
})()"""
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
    frames, calls = (60, 4000) if arguments.quick else (160, 40_000)
    print(machine())
    with tempfile.TemporaryDirectory() as name, Browser(Path(name), (1166, 700)) as browser:
        browser.load("about:blank", drawn="true")
        print(f"the browser's graphics start in {browser.ask(GRAPHICS):.0f} ms on an empty canvas")
        for robot in arguments.robots:
            _measure(browser, Path(name), robot, frames, calls)


def _measure(browser: Browser, folder: Path, robot: str, frames: int, calls: int) -> None:
    path = show(robot, language="en").write(folder / f"{robot}.html")
    starts: list[float] = []
    for _ in range(2 if ONCE else 6):
        _load(browser, path)
        starts.append(float(browser.ask("mafsil.timing.start")))
    sliding = browser.ask(FRAMES % ("false", frames))
    _load(browser, path)
    loop = browser.ask(FRAMES % ("true", frames))
    _load(browser, path)
    drawn = [browser.ask(DRAWING % (ghosts, frames // 3)) for ghosts in ("false", "true")]
    html = path.read_bytes()
    print(f"\n{robot}: {len(html) / 1e3:.0f} kB ({len(gzip.compress(html)) / 1e3:.0f} kB compressed), target 300 kB")
    print(f"  start  {starts[0]:.0f} ms first, {min(starts[1:]):.0f} ms then; target 100 ms")
    for name, taken in (("sliding", sliding), ("loop", loop)):
        print(
            f"  frame, {name:8} {_least(taken):5.2f} ms of script, p95 {np.percentile(taken, 95):.2f} ms; target 4 ms"
        )
    for one in drawn:
        size, shown = ("x".join(f"{x:.0f}" for x in one[key]) for key in ("size", "shown"))
        target = "; target 40 ms"
        print(f"  drawing, {one['ghosts']} ghosts {_least(one['taken']):5.1f} ms at {size} of {shown}{target}")
    kernels = Session(robot).arm.kernels
    for kernel, microseconds in browser.ask(CALLS % (calls, calls)).items():
        if kernel in kernels:
            print(f"  {kernel:20} {microseconds:6.2f} us a call in the page, inputs copied in")


def _load(browser: Browser, path: Path) -> None:
    browser.load("about:blank", drawn="true")
    browser.load(path)


def _least(taken: list[float]) -> float:
    """The least median of blocks of 20."""
    blocks = [taken[k : k + 20] for k in range(0, len(taken) - 19, 20)]
    return min(float(np.median(block)) for block in blocks)


if __name__ == "__main__":
    main()
