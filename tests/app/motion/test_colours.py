import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from app.motion import colours
from tests.app.legibility import LEAST_CONTRAST

# Machado, Oliveira, Fernandes 2009, full severity, on linear RGB.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
LAYERS = (colours.PLANNED, colours.SIMULATED, *colours.PINNED)
DARK_PANEL, DARK_CARD = (0x24,) * 3, (0x2E,) * 3
STATIC = Path(colours.__file__).parents[1] / "static"


def linear(rgb):
    c = np.asarray(rgb) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb_linear):
    xyz = XYZ @ np.clip(rgb_linear, 0, 1) / [0.9505, 1.0, 1.089]
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("sight", SIGHT)
def test_layers_are_told_apart(sight):
    seen = [lab(SIGHT[sight] @ linear(rgb)) for rgb in LAYERS]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 20


@pytest.mark.parametrize("ground", [(255, 255, 255), DARK_PANEL])
def test_layers_stand_out(ground):
    luminances = [XYZ[1] @ linear(rgb) + 0.05 for rgb in (ground, *LAYERS, *colours.COMPONENTS)]
    ratios = [max(L / luminances[0], luminances[0] / L) for L in luminances[1:]]
    assert min(ratios) > 2.5


@pytest.mark.parametrize(
    ("ground", "text"),
    [((255,) * 3, (0,) * 3), (DARK_PANEL, (0xC9,) * 3), (DARK_CARD, (0xC9,) * 3)],
)
def test_letters_in_the_colours_of_curves_can_be_read(ground, text):
    script = (STATIC / "plots.js").read_text()
    share = int(re.search(r"color-mix\(in srgb, \$\{colour\} (\d+)%", script)[1]) / 100
    for colour in (*LAYERS, *colours.COMPONENTS):
        letters = share * np.array(colour) + (1 - share) * np.array(text)
        dark, light = sorted(XYZ[1] @ linear(rgb) + 0.05 for rgb in (ground, letters))
        assert light / dark >= LEAST_CONTRAST


def test_components_are_told_apart_and_taken_for_no_motion():
    motions = (colours.PLANNED, colours.SIMULATED, colours.REFERENCE)
    seen = [lab(linear(rgb)) for rgb in (*colours.COMPONENTS, *motions)]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 20


MEANINGS = (
    colours.PLANNED,
    colours.SIMULATED,
    colours.REFERENCE,
    colours.FORCE,
    colours.COM,
    colours.REPLANNED,
    colours.TARGET,
    colours.BLOCK,
    colours.INFEASIBLE,
    colours.SUPPORT,
    colours.COLLISION,
    *colours.PINNED,
)
PHASES = (colours.TAKE_OFF, colours.FLIGHT, colours.LANDING, colours.REBOUND, colours.STANDING)


def test_colours_have_one_meaning():
    seen = [lab(linear(rgb)) for rgb in MEANINGS]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 20


def test_phases_are_tints():
    # Greyer than any motion's colour by far: a* and b* say how colourful a colour is.
    tinted = [np.hypot(*lab(linear(rgb))[1:]) for rgb in PHASES]
    assert max(tinted) < 0.5 * min(np.hypot(*lab(linear(rgb))[1:]) for rgb in LAYERS)
