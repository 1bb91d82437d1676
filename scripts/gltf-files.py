#!/usr/bin/env python3
"""Writes tests/gltf/{room,moving}.gltf, and the same two scenes for Mitsuba as tests/foreign/gltf-{room,moving}.xml.

The Mitsuba scenes have every place worked out here, by the formulas of the glTF specification and numpy, so that
they share nothing with lightbench's reader. The second one is the moment MOMENT_S of the first animation.
"""

import base64
import json
import pathlib
import struct
import zlib

import numpy as np

MOMENT_S = 0.7
SIZE = 64
DEPTH = 4
TESTS = pathlib.Path(__file__).resolve().parent.parent / "tests"


def checker_png():
    """2 × 2 texels, all different, so that a turned or mirrored image is seen."""
    rows = [[(200, 60, 60), (60, 200, 60)], [(60, 60, 200), (220, 220, 120)]]
    raw = b"".join(b"\0" + bytes(sum(row, ())) for row in rows)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def uri(data, kind="application/octet-stream"):
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


class Gltf:
    """Collects the parts of a file; its one buffer becomes a data URI."""

    def __init__(self):
        self.data = b""
        self.json = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            **{key: [] for key in ("nodes", "meshes", "materials", "accessors", "bufferViews", "cameras")},
        }

    def add(self, key, value):
        self.json[key].append(value)
        return len(self.json[key]) - 1

    def accessor(self, values, kind):
        values = np.asarray(values)
        code, layout = (5126, "<f4") if values.dtype.kind == "f" else (5123, "<u2")
        data = values.astype(layout).tobytes()
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data + b"\0" * (-len(data) % 4)
        accessor = {"bufferView": view, "componentType": code, "count": len(values), "type": kind}
        if kind in ("VEC3", "SCALAR"):
            flat = values.reshape(len(values), -1)
            accessor["min"], accessor["max"] = flat.min(0).tolist(), flat.max(0).tolist()
        return self.add("accessors", accessor)

    def quad(self, material):
        """[-1,1]² in the xy plane, normal +z: Mitsuba's rectangle, its texture coordinates included."""
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
        attributes = {
            "POSITION": self.accessor(corners, "VEC3"),
            "NORMAL": self.accessor(np.tile([0.0, 0.0, 1.0], (4, 1)), "VEC3"),
            "TEXCOORD_0": self.accessor((corners[:, :2] + 1) / 2, "VEC2"),
        }
        primitive = {"attributes": attributes, "mode": 6, "material": material}
        return self.add("meshes", {"primitives": [primitive]})

    def cube(self, material):
        """[-1,1]³ without normals: faces."""
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        indices = [i for a, b, c, d in faces for i in (a, b, c, a, c, d)]
        primitive = {
            "attributes": {"POSITION": self.accessor(corners, "VEC3")},
            "indices": self.accessor(np.array(indices), "SCALAR"),
            "material": material,
        }
        return self.add("meshes", {"primitives": [primitive]})

    def write(self, file):
        self.json["buffers"] = [{"byteLength": len(self.data), "uri": uri(self.data)}]
        file.parent.mkdir(exist_ok=True)
        file.write_text(json.dumps(self.json, indent=1) + "\n")


def trs(translation=(0, 0, 0), rotation=(0, 0, 0, 1), scale=(1, 1, 1)):
    x, y, z, w = np.asarray(rotation, dtype=float) / np.linalg.norm(rotation)
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.asarray(scale, dtype=float)
    matrix[:3, 3] = translation
    return matrix


def about(axis, degrees):
    half = np.radians(degrees) / 2
    axis = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    return [*(axis * np.sin(half)), np.cos(half)]


def product(q, r):
    """Quaternion q after r."""
    (a, b, c, d), (e, f, g, h) = q, r
    return [d * e + a * h + b * g - c * f, d * f - a * g + b * h + c * e, d * g + a * f - b * e + c * h, d * h - a * e - b * f - c * g]


def slerp(p, q, t):
    p, q = np.asarray(p, dtype=float), np.asarray(q, dtype=float)
    cosine = p @ q
    q, cosine = (-q, -cosine) if cosine < 0 else (q, cosine)
    angle = np.arccos(min(cosine, 1.0))
    return p if angle < 1e-9 else (np.sin((1 - t) * angle) * p + np.sin(t * angle) * q) / np.sin(angle)


def hermite(values, times, at):
    """Appendix C of the specification: values are (in-tangent, value, out-tangent) of every key."""
    k = max(i for i, time in enumerate(times) if time <= at)
    span = times[k + 1] - times[k]
    t = (at - times[k]) / span
    p, m, q, n = values[k][1], span * values[k][2], values[k + 1][1], span * values[k + 1][0]
    return (2 * t**3 - 3 * t**2 + 1) * p + (t**3 - 2 * t**2 + t) * m + (3 * t**2 - 2 * t**3) * q + (t**3 - t**2) * n


# Materials: what glTF says, and what Mitsuba makes of the plastic or conductor that it is mapped on.


def plastic(colour, roughness):
    pbr = {"metallicFactor": 0, "roughnessFactor": roughness}
    if isinstance(colour, str):
        pbr["baseColorTexture"] = {"index": 0}
        told = f'<texture type="bitmap" name="diffuse_reflectance"><string name="filename" value="{colour}"/><string name="filter_type" value="nearest"/></texture>'
    else:
        pbr["baseColorFactor"] = [*colour, 1]
        told = f'<rgb name="diffuse_reflectance" value="{", ".join(map(str, colour))}"/>'
    told = f'<bsdf type="roughplastic"><string name="distribution" value="ggx"/><float name="alpha" value="{roughness**2:.6g}"/><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>{told}</bsdf>'
    return {"pbrMetallicRoughness": pbr}, told


def metal(colour, roughness):
    pbr = {"metallicFactor": 1, "roughnessFactor": roughness, "baseColorFactor": [*colour, 1]}
    told = f'<bsdf type="roughconductor"><string name="material" value="none"/><string name="distribution" value="ggx"/><float name="alpha" value="{roughness**2:.6g}"/><rgb name="specular_reflectance" value="{", ".join(map(str, colour))}"/></bsdf>'
    return {"pbrMetallicRoughness": pbr}, told


class Scene:
    """A glTF file and a Mitsuba scene, written side by side."""

    def __init__(self, title):
        self.gltf = Gltf()
        self.shapes = []
        self.title = title
        self.lights = []

    def material(self, pair, **more):
        declared, told = pair
        return self.gltf.add("materials", {**declared, **more}), f'<bsdf type="twosided">{told}</bsdf>'

    def shape(self, kind, material, world, parent=None, emitted=None, mesh=None, **node):
        """A node with a quad or a cube, below another node or at the top; `world` is its place at the moment."""
        index, told = material
        mesh = getattr(self.gltf, kind)(index)
        number = self.node({**node, "mesh": mesh}, parent)
        words = " ".join(f"{x:.9g}" for x in world.ravel())
        shape = {"quad": "rectangle", "cube": "cube"}[kind]
        light = f'<emitter type="area"><rgb name="radiance" value="{emitted}"/></emitter>' if emitted else ""
        self.shapes.append(f'  <shape type="{shape}"><transform name="to_world"><matrix value="{words}"/></transform>{told}{light}</shape>')
        return number

    def node(self, node, parent=None):
        plain = lambda v: v.tolist() if isinstance(v, np.ndarray) else [float(x) for x in v] if isinstance(v, (list, tuple)) else v
        number = self.gltf.add("nodes", {key: plain(value) for key, value in node.items()})
        above = self.gltf.json["scenes"][0]["nodes"] if parent is None else self.gltf.json["nodes"][parent].setdefault("children", [])
        above.append(number)
        return number

    def light(self, light, told):
        extension = self.gltf.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})
        self.gltf.json["extensionsUsed"] = ["KHR_lights_punctual", "KHR_materials_emissive_strength"]
        extension["lights"].append(light)
        self.lights.append(f"  {told}")
        return {"KHR_lights_punctual": {"light": len(extension["lights"]) - 1}}

    def write(self, name, camera_world, yfov):
        self.gltf.write(TESTS / "gltf" / f"{name}.gltf")
        origin, back, up = camera_world[:3, 3], camera_world[:3, 2], camera_world[:3, 1]
        point = lambda p: ", ".join(f"{x:.9g}" for x in p)
        text = f"""<scene version="3.0.0">
  <!-- {self.title} Written by scripts/gltf-files.py. -->
  <integrator type="path"><integer name="max_depth" value="{DEPTH}"/><integer name="rr_depth" value="1000"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="{np.degrees(yfov):.9g}"/>
    <string name="fov_axis" value="y"/>
    <transform name="to_world"><lookat origin="{point(origin)}" target="{point(origin - back)}" up="{point(up)}"/></transform>
    <film type="hdrfilm"><integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/><rfilter type="box"/></film>
    <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
  </sensor>
""" + "\n".join(self.shapes + self.lights) + "\n</scene>\n"
        (TESTS / "foreign" / f"gltf-{name}.xml").write_text(text)


def room():
    scene = Scene("tests/gltf/room.gltf: plastic, metal, a texture, a lamp, lights without extent, a mirrored node.")
    image = checker_png()
    (TESTS / "foreign" / "gltf-texels.png").write_bytes(image)
    scene.gltf.json["images"] = [{"uri": uri(image, "image/png")}]
    scene.gltf.json["samplers"] = [{"magFilter": 9728, "minFilter": 9728}]
    scene.gltf.json["textures"] = [{"source": 0, "sampler": 0}]
    ground = scene.material(plastic((0.6, 0.55, 0.5), 1), doubleSided=True)
    panel = scene.material(plastic("gltf-texels.png", 0.5), doubleSided=True)
    gold = scene.material(metal((0.9, 0.6, 0.3), 0.5))
    blue = scene.material(plastic((0.1, 0.3, 0.7), 0.4))
    strength = {"emissiveFactor": [1, 0.9, 0.7], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 12}}}
    lamp = scene.material(plastic((0, 0, 0), 1), **strength)

    # Everything stands on a stage that is itself moved and turned.
    stage = {"translation": [3, 0.5, -2], "rotation": about([0, 1, 0], 40)}
    world = trs(**stage)
    top = scene.node({"name": "stage", **stage})

    def put(kind, material, parent, above, place, name, **more):
        return scene.shape(kind, material, above @ trs(**place), parent, name=name, **more, **place), above @ trs(**place)

    put("quad", ground, top, world, {"rotation": about([1, 0, 0], -90), "scale": (4, 4, 4)}, "floor")
    put("quad", ground, top, world, {"translation": (0, 0, -3), "scale": (4, 4, 4)}, "wall")
    put("quad", panel, top, world, {"translation": (-1.4, 1.4, -2.4), "rotation": about([0, 1, 0], 20), "scale": (1, 1, 1)}, "panel")
    block, there = put("cube", gold, top, world, {"translation": (1.3, 0.7, -0.4), "rotation": about([0, 1, 0], 30), "scale": (0.7, 0.7, 0.7)}, "block")
    lid = trs((0.2, 1.3, 0), about([0, 1, 0], 25), (0.5, 0.3, 0.8))
    scene.shape("cube", blue, there @ lid, block, name="lid", matrix=lid.T.ravel())
    put("cube", blue, top, world, {"translation": (-1.1, 0.5, 0.4), "rotation": about([0, 1, 0], -20), "scale": (-0.5, 0.5, 0.4)}, "mirrored")
    put("quad", lamp, top, world, {"translation": (0.3, 3.6, 0.5), "rotation": about([1, 0, 0], 90), "scale": (0.5, 0.5, 0.5)}, "lamp", emitted="12, 10.8, 8.4")

    spot = {"translation": [2.5, 3.5, 2], "rotation": product(about([0, 1, 0], 45), about([1, 0, 0], -50))}
    placed = world @ trs(**spot)
    words = " ".join(f"{x:.9g}" for x in (placed @ np.diag([-1, 1, -1, 1])).ravel())
    light = {"type": "spot", "color": [1, 0.5, 0.25], "intensity": 40, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}}
    told = f'<emitter type="spot"><transform name="to_world"><matrix value="{words}"/></transform><rgb name="intensity" value="40, 20, 10"/><float name="cutoff_angle" value="{np.degrees(0.5):.9g}"/><float name="beam_width" value="{np.degrees(0.2):.9g}"/></emitter>'
    scene.node({"name": "spot", **spot, "extensions": scene.light(light, told)}, top)
    point = {"translation": [-2.5, 1, 1]}
    place = (world @ trs(**point))[:3, 3]
    light = {"type": "point", "color": [0.5, 1, 0.8], "intensity": 2}
    told = f'<emitter type="point"><point name="position" value="{", ".join(f"{x:.9g}" for x in place)}"/><rgb name="intensity" value="1, 2, 1.6"/></emitter>'
    scene.node({"name": "point", **point, "extensions": scene.light(light, told)}, top)
    sun = {"rotation": product(about([0, 1, 0], -30), about([1, 0, 0], -60))}
    along = -(world @ trs(**sun))[:3, 2]
    light = {"type": "directional", "intensity": 0.4}
    told = f'<emitter type="directional"><vector name="direction" value="{", ".join(f"{x:.9g}" for x in along)}"/><rgb name="irradiance" value="0.4, 0.4, 0.4"/></emitter>'
    scene.node({"name": "sun", **sun, "extensions": scene.light(light, told)}, top)

    camera = scene.gltf.add("cameras", {"name": "front", "type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.0, "znear": 0.1}})
    looks = {"translation": [0.4, 2.4, 7.5], "rotation": about([1, 0, 0], -10)}
    scene.node({"name": "camera", "camera": camera, **looks}, top)
    scene.write("room", world @ trs(**looks), 0.7)


def moving():
    scene = Scene(f"tests/gltf/moving.gltf at {MOMENT_S} s: an arm that moves and turns, a hand on it, a lamp, a camera.")
    ground = scene.material(plastic((0.6, 0.55, 0.5), 1), doubleSided=True)
    gold = scene.material(metal((0.9, 0.6, 0.3), 0.6))
    red = scene.material(plastic((0.7, 0.15, 0.1), 0.5))
    at = MOMENT_S

    # Keys: in-tangent, value, out-tangent for cubic splines.
    slide_times = [0.0, 1.0, 2.0]
    slide = np.array([[0.0, 0.5, 0.0], [1.0, 0.8, 0.5], [0.0, 0.5, -0.5]])
    sway_times = [0.0, 1.0]
    angles = [np.array(about([0, 1, 0], d)) for d in (-20, 70)]
    sway = np.array([[[0, 0, 0, 0], angles[0], [0, 0.6, 0, -0.1]], [[0, 0.2, 0.1, -0.2], angles[1], [0, 0, 0, 0]]])
    twist_times = [0.25, 0.75, 1.5]
    twist = np.array([about([0, 0, 1], 0), about([0, 0, 1], 80), about([1, 0, 0], 60)])
    twist[1] *= -1  # The same turn: slerp must take the short way.
    grow_times = [0.0, 0.5, 1.0]
    grow = np.array([[0.3, 0.3, 0.3], [0.3, 0.6, 0.3], [0.9, 0.9, 0.9]])
    fly_times = [0.0, 2.0]
    fly = np.array([[[0, 0, 0], [0, 2.5, 7], [2, 0, -1]], [[1, 0, 0], [2, 2, 5], [0, 0, 0]]], dtype=float)
    look_times = [0.0, 1.0]
    look = np.array([about([1, 0, 0], -15), product(about([0, 1, 0], 12), about([1, 0, 0], -15))])

    t = at / 1.0
    arm_at = {
        "translation": (1 - t) * slide[0] + t * slide[1],
        "rotation": hermite(sway, sway_times, at),
    }
    hand_at = {
        "translation": np.array([0.0, 1.2, 0.4]),
        "rotation": slerp(twist[0], twist[1], (at - 0.25) / 0.5),
        "scale": grow[1],
    }
    camera_at = {"translation": hermite(fly, fly_times, at), "rotation": slerp(look[0], look[1], at)}

    flat = about([1, 0, 0], -90)
    scene.shape("quad", ground, trs(rotation=flat, scale=(5, 5, 5)), name="floor", rotation=flat, scale=(5, 5, 5))
    arm_world = trs(**arm_at)
    arm = scene.node({"name": "arm", "translation": [0, 0.5, 0]})
    body = {"scale": (0.3, 0.7, 0.3), "translation": (0, 0.2, 0)}
    scene.shape("cube", gold, arm_world @ trs(**body), arm, name="body", **body)
    hand_world = arm_world @ trs(**hand_at)
    hand = scene.shape("cube", red, hand_world, arm, name="hand", translation=(0, 1.2, 0.4), scale=(0.3, 0.3, 0.3))
    torch = {"translation": (0.6, 1.6, 0.8)}
    place = (arm_world @ trs(**torch))[:3, 3]
    told = f'<emitter type="point"><point name="position" value="{", ".join(f"{x:.9g}" for x in place)}"/><rgb name="intensity" value="6, 5, 4"/></emitter>'
    light = {"type": "point", "name": "torch", "color": [1, 5 / 6, 4 / 6], "intensity": 6}
    scene.node({"name": "torch", **torch, "extensions": scene.light(light, told)}, arm)
    sun = {"rotation": product(about([0, 1, 0], 30), about([1, 0, 0], -60))}
    along = -trs(**sun)[:3, 2]
    told = f'<emitter type="directional"><vector name="direction" value="{", ".join(f"{x:.9g}" for x in along)}"/><rgb name="irradiance" value="1, 1, 1"/></emitter>'
    scene.node({"name": "sun", **sun, "extensions": scene.light({"type": "directional"}, told)})
    camera = scene.gltf.add("cameras", {"name": "crane", "type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.0, "znear": 0.1}})
    eye = scene.node({"name": "eye", "camera": camera, "translation": [0, 2.5, 7], "rotation": look[0]})

    animation = {"name": "all", "channels": [], "samplers": []}
    for node, path, times, values, how in [
        (arm, "translation", slide_times, slide, "LINEAR"),
        (arm, "rotation", sway_times, sway, "CUBICSPLINE"),
        (hand, "rotation", twist_times, twist, "LINEAR"),
        (hand, "scale", grow_times, grow, "STEP"),
        (eye, "translation", fly_times, fly, "CUBICSPLINE"),
        (eye, "rotation", look_times, look, "LINEAR"),
    ]:
        values = values.reshape(-1, values.shape[-1])
        sampler = {
            "input": scene.gltf.accessor(np.array(times), "SCALAR"),
            "output": scene.gltf.accessor(values, "VEC4" if path == "rotation" else "VEC3"),
            "interpolation": how,
        }
        animation["samplers"].append(sampler)
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})
    scene.gltf.json["animations"] = [animation]
    scene.write("moving", trs(**camera_at), 0.7)


room()
moving()
