#!/usr/bin/env python3
"""Prints the table of src/scene/mitsuba/solar.rs: `python3 scripts/solar-table.py [SOURCE]`; needs the package `mitsuba`.

Mitsuba's `sunsky` without its sky is asked for the radiance at points spread evenly over the disc of the sun, under some
azimuths, since single precision blurs the rim of so small a disc. Their mean times the solid angle of the disc is the irradiance of a surface that faces the sun; what lies below the horizon is black.
With SOURCE the table in that file is compared with what would be printed: exit code 1 where an entry differs.
"""

import math
import pathlib
import re
import sys

import mitsuba as mi

TURBIDITIES = range(1, 11)
ELEVATIONS = 21
POINTS = 1024
AZIMUTHS = 16
GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))


def turned(x, y, z, azimuth):
    sine, cosine = math.sin(azimuth), math.cos(azimuth)
    return [x * cosine - y * sine, x * sine + y * cosine, z]


def disc(elevation, radius):
    """Unit vectors to points of a sun of azimuth 0, z up: a spiral of equal solid angles."""
    sine, cosine = math.sin(elevation), math.cos(elevation)
    for i in range(POINTS):
        along = 1 - (1 - math.cos(radius)) * (i + 0.5) / POINTS
        away = math.sqrt(1 - along * along)
        up, aside = away * math.cos(i * GOLDEN_ANGLE), away * math.sin(i * GOLDEN_ANGLE)
        yield along * cosine - up * sine, aside, along * sine + up * cosine


def irradiance(turbidity, elevation):
    """Linear RGB, W/(m² nm)."""
    # On the horizon itself Mitsuba's sun is black.
    elevation = max(elevation, 1e-6)
    total = [0.0] * 3
    seen = mi.SurfaceInteraction3f()
    for azimuth in (math.tau * (k + 0.5) / AZIMUTHS for k in range(AZIMUTHS)):
        sun = turned(math.cos(elevation), 0, math.sin(elevation), azimuth)
        sky = mi.load_dict({"type": "sunsky", "turbidity": float(turbidity), "sun_direction": sun, "sky_scale": 0.0})
        radius = math.radians(float(re.search(r"Sun aperture = ([0-9.]+)", str(sky))[1]) / 2)
        for direction in disc(elevation, radius):
            seen.wi = mi.Vector3f([-c for c in turned(*direction, azimuth)])
            total = [before + float(c) for before, c in zip(total, sky.eval(seen))]
    solid_angle = 2 * math.pi * (1 - math.cos(radius))
    # The model's blue falls below 0 where the sun is low.
    return [max(c / (POINTS * AZIMUTHS) * solid_angle, 0.0) for c in total]


def written(value):
    """Four digits, seven places at most, as a Rust number."""
    places = 7 if value == 0 else min(7, 3 - math.floor(math.log10(value)))
    return f"{value:.{places}f}".rstrip("0").ljust(3, "0") if value < 10 else f"{value:.1f}"


def main():
    mi.set_variant("scalar_rgb")
    heights = [(k / (ELEVATIONS - 1)) ** 3 * math.pi / 2 for k in range(ELEVATIONS)]
    lines = []
    for turbidity in TURBIDITIES:
        lines.append("    [")
        lines += ["        [" + ", ".join(map(written, irradiance(turbidity, e))) + "]," for e in heights]
        lines.append("    ],")
    table = "\n".join(lines)
    if len(sys.argv) < 2:
        print(table)
    elif table not in pathlib.Path(sys.argv[1]).read_text():
        sys.exit(f"the table of {sys.argv[1]} is another one")


main()
