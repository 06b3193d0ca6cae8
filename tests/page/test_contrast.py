"""Every colour of text stands out from what lies behind it, light and dark: WCAG 2.2, 1.4.3, at least 4.5 to 1."""

from __future__ import annotations

import re

import pytest

from mafsil.scene.modules import read

TEXTS = ("ink", "soft", "accent", "bad", "good", "warn")
GROUNDS = {
    "ink": ("paper", "card", "stage-top", "stage-low"),
    "soft": ("paper", "card", "stage-top", "stage-low", "good-soft", "warn-soft", "bad-soft"),
    "accent": ("card",),
    "bad": ("card", "bad-soft"),
    "good": ("card", "good-soft"),
    "warn": ("card", "warn-soft"),
}


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb. Reference: WCAG 2.2, definition of relative luminance."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def test_of_black_and_white() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)


def test_texts_stand_out() -> None:
    rows = re.findall(r"--([\w-]+): light-dark\((#[0-9a-f]{6}), (#[0-9a-f]{6})\)", read("page/page.css"))
    for name, place in (("light", 1), ("dark", 2)):
        colours = {row[0]: row[place] for row in rows}
        pairs = [(a, b) for a in TEXTS for b in GROUNDS[a] if a in colours and b in colours]
        assert len(pairs) >= 9
        found = {f"{name} {a} on {b}": round(contrast(colours[a], colours[b]), 2) for a, b in pairs}
        found[f"{name} on accent"] = contrast(colours["on-accent"], colours["accent"])
        assert not {pair: ratio for pair, ratio in found.items() if ratio < 4.5}
