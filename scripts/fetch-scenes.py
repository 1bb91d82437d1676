#!/usr/bin/env python3
"""Obtains the scenes and environment maps of the experiments from their official homes.

    scripts/fetch-scenes.py --list
    scripts/fetch-scenes.py --dest scenes-downloaded staircase kitchen pine_attic
    scripts/fetch-scenes.py --dest scenes-downloaded            (everything of kind `scene`)
    scripts/fetch-scenes.py --dest scenes-downloaded --verify   (no download, only checks)

Afterwards: export LIGHTBENCH_SCENES=scenes-downloaded

Every archive is tested, unpacked beside its place and moved there when it is complete; every XML
file must parse and every file that a scene names must be there. The sha256 of each download is
recorded in LOCK (scenes.lock.json in the destination unless --lock is given); a later download that
differs is refused unless --update is given. Exit code 0: everything asked for is there and checked;
1: something failed, and each failure is printed; 2: wrong usage.

Needs nothing but Python 3.8.
"""

import argparse
import hashlib
import http.client
import json
import os
import re
import shutil
import sys
import tempfile
import urllib.error
import urllib.request
import xml.etree.ElementTree as ElementTree
import zipfile

BITTERLI = "https://benedikt-bitterli.me/resources/mitsuba/{}.zip"
MCGUIRE = "https://casual-effects.com/g3d/data10/research/model/{}/{}.zip"
POLY_HAVEN = "https://dl.polyhaven.org/file/ph-assets/HDRIs/hdr/1k/{}_1k.hdr"

# Bitterli's rendering resources (Mitsuba version), by their names there; licences in each archive.
BITTERLI_SCENES = [
    "bathroom", "bathroom2", "bedroom", "classroom", "cornell-box", "dining-room", "glass-of-water",
    "kitchen", "lamp", "living-room", "living-room-2", "living-room-3", "material-testball",
    "spaceship", "staircase", "staircase2", "teapot", "veach-ajar", "veach-bidir", "veach-mis",
]

# McGuire Computer Graphics Archive: OBJ files, to be used from a scene.toml.
MCGUIRE_MODELS = {
    "crytek-sponza": ("sponza", "sponza"),
    "sibenik": ("sibenik", "sibenik"),
    "conference": ("conference", "conference"),
    "breakfast-room-obj": ("breakfast_room", "breakfast_room"),
}

# Poly Haven (CC0).
HDRIS = [
    "adams_place_bridge", "aerodynamics_workshop", "basement_boxing_ring", "blue_photo_studio",
    "brown_photostudio_02", "chinese_garden", "comfy_cafe", "dikhololo_night", "drachenfels_cellar",
    "empty_warehouse_01", "evening_meadow", "factory_yard", "fireplace", "immenstadter_horn",
    "industrial_pipe_and_valve_02", "kiara_1_dawn", "kloppenheim_05", "lapa", "lebombo",
    "lythwood_lounge", "neuer_zollhof", "phalzer_forest_01", "pine_attic", "potsdamer_platz",
    "red_wall", "rooitou_park", "spruit_sunrise", "st_fagans_interior", "studio_garden",
    "studio_small_03", "thatch_chapel", "venice_sunset", "vignaioli_night",
]


class Failure(Exception):
    """Something that the user should read; the other items go on."""


def catalogue():
    """Name → (kind, address)."""
    items = {name: ("scene", BITTERLI.format(name)) for name in BITTERLI_SCENES}
    for name, (folder, archive) in MCGUIRE_MODELS.items():
        items[name] = ("model", MCGUIRE.format(folder, archive))
    for name in HDRIS:
        items[name] = ("hdri", POLY_HAVEN.format(name))
    return items


def place_of(dest, name, kind):
    """The folder of a scene or model, the file of a map."""
    if kind == "hdri":
        return os.path.join(dest, "hdri", name + "_1k.hdr")
    return os.path.join(dest, name)


def sha256_of(path):
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        for block in iter(lambda: file.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()


def download(address, path, timeout):
    request = urllib.request.Request(address, headers={"User-Agent": "lightbench-fetch-scenes"})
    try:
        with urllib.request.urlopen(request, timeout=timeout) as answer, open(path, "wb") as file:
            shutil.copyfileobj(answer, file, 1 << 20)
            expected = answer.headers.get("Content-Length")
    except urllib.error.HTTPError as error:
        raise Failure("{}: the server answers {} {}".format(address, error.code, error.reason))
    except (urllib.error.URLError, http.client.HTTPException, OSError) as error:
        raise Failure("{}: cannot be reached ({})".format(address, getattr(error, "reason", error)))
    size = os.path.getsize(path)
    if expected is not None and size != int(expected):
        raise Failure("{}: {} of {} bytes arrived; try again".format(address, size, expected))


def check_lock(lock, name, address, digest, update):
    """Compares with what was recorded, or records it."""
    known = lock.get(name)
    if known and known["sha256"] != digest and not update:
        raise Failure(
            "sha256 is {} but {} was recorded; the publisher changed the file (--update accepts it)"
            .format(digest, known["sha256"])
        )
    lock[name] = {"url": address, "sha256": digest}


def unpack(archive, folder):
    """Unpacks a tested archive; a single top folder is stripped."""
    try:
        with zipfile.ZipFile(archive) as zipped:
            bad = zipped.testzip()
            if bad is not None:
                raise Failure("the archive is damaged at {}".format(bad))
            root = os.path.realpath(folder)
            for member in zipped.namelist():
                target = os.path.realpath(os.path.join(folder, member))
                if target != root and not target.startswith(root + os.sep):
                    raise Failure("the archive wants to write outside its folder: {}".format(member))
            zipped.extractall(folder)
    except zipfile.BadZipFile as error:
        raise Failure("not a zip archive: {}".format(error))
    entries = os.listdir(folder)
    if len(entries) == 1 and os.path.isdir(os.path.join(folder, entries[0])):
        return os.path.join(folder, entries[0])
    return folder


def referenced_files(root):
    """Files that a Mitsuba scene names, with $parameters replaced by their defaults."""
    defaults = {e.get("name"): e.get("value") for e in root.iter("default")}
    for element in root.iter():
        name = element.get("value") if element.get("name") == "filename" else element.get("filename")
        if name:
            yield re.sub(r"\$(\w+)", lambda m: defaults.get(m.group(1)) or m.group(0), name)


def verify_scene(folder):
    """Problems of a folder with Mitsuba XML files, as sentences."""
    problems = []
    files = sorted(f for f in os.listdir(folder) if f.endswith(".xml"))
    if "scene.xml" not in files:
        problems.append("there is no scene.xml")
    for file in files:
        try:
            root = ElementTree.parse(os.path.join(folder, file)).getroot()
        except ElementTree.ParseError as error:
            problems.append("{}: not well-formed XML: {}".format(file, error))
            continue
        if root.tag != "scene":
            problems.append("{}: <{}> instead of <scene>".format(file, root.tag))
        for name in sorted(set(referenced_files(root))):
            path = os.path.join(folder, name.replace("\\", "/"))
            if not os.path.isfile(path):
                problems.append("{}: {} is absent".format(file, name))
            elif os.path.getsize(path) == 0:
                problems.append("{}: {} is empty".format(file, name))
    return problems


def verify_model(folder):
    for _, _, files in os.walk(folder):
        if any(f.lower().endswith(".obj") for f in files):
            return []
    return ["there is no .obj file"]


def verify_hdri(path):
    """A Radiance file starts with its signature and has a resolution line and data after it."""
    with open(path, "rb") as file:
        head = file.read(4096)
    if not head.startswith((b"#?RADIANCE", b"#?RGBE")):
        return ["not a Radiance HDR file"]
    size = re.search(rb"\n\n-Y (\d+) \+X (\d+)\n", head)
    if not size:
        return ["no resolution line in the header"]
    # Run lengths: at least two bytes for each of the four channels of a row, after a 4-byte mark.
    rows = int(size.group(1))
    if os.path.getsize(path) - size.end() < rows * 12:
        return ["the file is truncated"]
    return []


def verify(path, kind):
    if not os.path.exists(path):
        return ["{} is not there".format(path)]
    return {"scene": verify_scene, "model": verify_model, "hdri": verify_hdri}[kind](path)


def fetch(name, item, options, lock):
    """Downloads, checks and puts in place one item."""
    kind, address = item
    place = place_of(options.dest, name, kind)
    os.makedirs(os.path.dirname(place) or ".", exist_ok=True)
    with tempfile.TemporaryDirectory(dir=options.dest, prefix=".fetch-") as work:
        received = os.path.join(work, "download")
        download(address, received, options.timeout)
        digest = sha256_of(received)
        if kind == "hdri":
            ready = received
        else:
            folder = os.path.join(work, "unpacked")
            os.mkdir(folder)
            ready = unpack(received, folder)
        problems = verify(ready, kind)
        if problems:
            raise Failure("; ".join(problems))
        check_lock(lock, name, address, digest, options.update)
        if os.path.isdir(place):
            shutil.rmtree(place)
        os.replace(ready, place)


def process(name, item, options, lock):
    """One item; returns what happened, raises Failure."""
    place = place_of(options.dest, name, item[0])
    if options.verify:
        problems = verify(place, item[0])
        if problems:
            raise Failure("; ".join(problems))
        return "complete"
    if os.path.exists(place) and not options.force and not verify(place, item[0]):
        return "already there, complete"
    fetch(name, item, options, lock)
    return "fetched and checked"


def read_lock(path):
    if not os.path.exists(path):
        return {}
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except ValueError as error:
        sys.exit("{}: {} (delete it to start anew)".format(path, error))


def write_lock(path, lock):
    with open(path + ".new", "w", encoding="utf-8") as file:
        json.dump(lock, file, indent=2, sort_keys=True)
        file.write("\n")
    os.replace(path + ".new", path)


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="what to fetch; default: all scenes")
    parser.add_argument("--list", action="store_true", help="print the names, kinds and addresses")
    parser.add_argument("--dest", default="scenes-downloaded", help="folder (default: %(default)s)")
    parser.add_argument("--lock", help="where sha256 sums are kept (default: DEST/scenes.lock.json)")
    parser.add_argument("--verify", action="store_true", help="check what is there, fetch nothing")
    parser.add_argument("--update", action="store_true", help="accept downloads that have changed")
    parser.add_argument("--force", action="store_true", help="fetch again what is already complete")
    parser.add_argument("--timeout", type=float, default=60, help="seconds (default: %(default)s)")
    return parser, parser.parse_args(arguments)


def main(arguments):
    parser, options = parse_arguments(arguments)
    items = catalogue()
    if options.list:
        for name, (kind, address) in sorted(items.items(), key=lambda i: (i[1][0], i[0])):
            print("{:6} {:30} {}".format(kind, name, address))
        return 0
    unknown = [name for name in options.names if name not in items]
    if unknown:
        parser.error("unknown: {}; --list prints the names".format(", ".join(unknown)))
    names = options.names or BITTERLI_SCENES
    lock_path = options.lock or os.path.join(options.dest, "scenes.lock.json")
    lock = read_lock(lock_path)
    if not options.verify:
        os.makedirs(options.dest, exist_ok=True)
    failures = 0
    for name in names:
        try:
            print("{}: {}".format(name, process(name, items[name], options, lock)), flush=True)
        except (Failure, OSError) as failure:
            failures += 1
            print("{}: FAILED: {}".format(name, failure), file=sys.stderr, flush=True)
        else:
            if not options.verify:
                write_lock(lock_path, lock)
    if failures:
        print("{} of {} failed".format(failures, len(names)), file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
