#!/usr/bin/env python3
"""Renders tests/foreign/*.xml with Mitsuba 3 (pip install mitsuba), which shares no code with lightbench.

Writes NAME.exr, the mean of several independent renderings, and NAME.noise.exr, the standard error of that mean,
which tests/truth_foreign.rs compares lightbench with. Names as arguments render these alone.
"""

import pathlib
import sys

import mitsuba as mi
import numpy as np

RENDERINGS, SAMPLES = 16, 256

mi.set_variant("scalar_rgb")
folder = pathlib.Path(__file__).resolve().parent.parent / "tests" / "foreign"
for file in sorted(folder.glob("*.xml")):
    if sys.argv[1:] and file.stem not in sys.argv[1:]:
        continue
    scene = mi.load_file(str(file))
    images = np.stack([np.array(mi.render(scene, spp=SAMPLES, seed=seed))[..., :3] for seed in range(RENDERINGS)])
    mean = images.mean(axis=0)
    error = images.std(axis=0, ddof=1) / np.sqrt(RENDERINGS)
    for name, values in [("exr", mean), ("noise.exr", error)]:
        bitmap = mi.Bitmap(np.ascontiguousarray(values, dtype=np.float32))
        bitmap.write(str(file.with_suffix("." + name)))
    print(f"{file.name}: mean {mean.mean():.5f}, standard error of a pixel {np.sqrt((error**2).mean()):.2e}")
