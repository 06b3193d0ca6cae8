"""Make the pictures of README and docs: the reports of the demo, by Chromium, and robots drawn by mafsil."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).parent / "images"
FLAGS = (
    "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--hide-scrollbars", "--virtual-time-budget=3000",
)  # fmt: skip
VIEWS = (("demo.png", "en", "4.4", "1400,800"), ("demo_ar.png", "ar", "4.4", "1400,800"))

MOTIONS = {
    "screw_motion.png": "--screw 0.2 0.1 1 0.8 0 0 0.12 150 --degrees",
    "gimbal_lock.png": "--euler ZYX 30 90 50 --degrees",
}
"""Pictures of docs/rigid-motions.md, and the motion of each as `mafsil convert` takes it."""


POSTURES = {"postures_ur5e.png": "ur5e --pose 0.4 0.1 0.3 180 0 90 --degrees --all"}
"""Pictures of docs/inverse-kinematics.md, and the pose of each as `mafsil ik` takes it."""


LINKAGES = {"six_bar_synthesis.png": f"synthesis {Path(__file__).parents[1]}/examples/synthesis/six_bar.toml"}
"""Pictures of docs/linkage_synthesis.md, and the task of each."""


def halve(path: Path) -> None:
    """Make a picture of the page's renderer half as large: it is drawn with two dots a pixel."""
    with Image.open(path) as picture:
        half = picture.convert("RGB").resize((picture.width // 2, picture.height // 2), Image.Resampling.LANCZOS)
    half.save(path, optimize=True)


def main() -> int:
    """Run the demo in both languages and photograph its reports."""
    mafsil = [sys.executable, "-m", "mafsil.cli"]
    IMAGES.mkdir(exist_ok=True)
    for robot in ("panda", "puma560", "ur5e"):
        subprocess.run(
            [*mafsil, "show", robot, "--picture", str(IMAGES / f"{robot}.png")], check=True, stdout=subprocess.DEVNULL
        )
        halve(IMAGES / f"{robot}.png")
    pictures = [(picture, f"convert {motion}") for picture, motion in MOTIONS.items()]
    pictures += [(picture, f"ik {pose}") for picture, pose in POSTURES.items()]
    pictures += LINKAGES.items()
    for picture, question in pictures:
        words = [*question.split(), "--picture", str(IMAGES / picture)]
        subprocess.run([*mafsil, *words], check=True, stdout=subprocess.DEVNULL)
        if picture in POSTURES | LINKAGES:
            halve(IMAGES / picture)
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        print("no Chromium found: the photographs of the report stay as they are", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        for name, language, moment, size in VIEWS:
            out = Path(folder) / language
            subprocess.run(
                [*mafsil, "demo", "--out", str(out), "--lang", language], check=True, stdout=subprocess.DEVNULL
            )
            page = f"{(out / 'report.html').as_uri()}#t={moment}"
            words = [
                browser,
                *FLAGS,
                f"--user-data-dir={folder}/profile",
                f"--window-size={size}",
                f"--screenshot={IMAGES / name}",
                page,
            ]
            subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return 0


if __name__ == "__main__":
    sys.exit(main())
