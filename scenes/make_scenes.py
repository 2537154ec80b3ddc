#!/usr/bin/env python3
"""Writes cornell.gltf, crumbs.gltf, paper_room.gltf and prism.gltf beside itself; docs/scenes.md explains them.

The scenes are kept as glTF, so that other programs open them; this file holds the same numbers where people can read
them. Lengths are metres, y is up, faces are counter-clockwise seen from their front. Only Python's own library is used.
"""

import base64
import json
import math
import pathlib
import struct


# ---- glTF -----------------------------------------------------------------------------------------------------------

class Gltf:
    """Collects one file. Meshes are given as lists of faces, a face as a list of corners."""

    def __init__(self, title):
        self.bytes = b""
        self.root = {
            "asset": {"version": "2.0", "generator": "Lumenfarm scenes/make_scenes.py", "extras": {"title": title}},
            "extensionsUsed": [], "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "cameras": [], "materials": [],
            "meshes": [], "accessors": [], "bufferViews": [], "buffers": []}

    def use(self, extension):
        if extension not in self.root["extensionsUsed"]:
            self.root["extensionsUsed"].append(extension)

    def add(self, kind, element):
        self.root[kind].append(element)
        return len(self.root[kind]) - 1

    def node(self, node):
        self.root["scenes"][0]["nodes"].append(self.add("nodes", node))

    def material(self, name, rgb=(1, 1, 1), metallic=0, roughness=1, emissive=None, extensions=None, spectra=None):
        material = {"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": [*rgb, 1], "metallicFactor": metallic, "roughnessFactor": roughness}}
        if emissive:
            material["emissiveFactor"] = list(emissive)
        if extensions:
            material["extensions"] = extensions
            for extension in extensions:
                self.use(extension)
        if spectra:
            material["extras"] = {"lumenfarm_spectra": spectra}
        return self.add("materials", material)

    def accessor(self, data, element):
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data + b"\0" * (-len(data) % 4)
        return self.add("accessors", {"bufferView": view, **element})

    def primitive(self, faces, material):
        """Corners at the same place become one vertex; faces become fans."""
        places, indices = {}, []
        for face in faces:
            corners = [places.setdefault(struct.pack("<3f", *corner), len(places)) for corner in face]
            for i in range(1, len(corners) - 1):
                indices += [corners[0], corners[i], corners[i + 1]]
        points = [struct.unpack("<3f", place) for place in places]
        position = self.accessor(b"".join(places), {
            "componentType": 5126, "count": len(points), "type": "VEC3",
            "min": [min(p[axis] for p in points) for axis in range(3)],
            "max": [max(p[axis] for p in points) for axis in range(3)]})
        index = self.accessor(struct.pack(f"<{len(indices)}H", *indices),
                              {"componentType": 5123, "count": len(indices), "type": "SCALAR"})
        return {"attributes": {"POSITION": position}, "indices": index, "material": material}

    def object(self, name, *parts, **placement):
        """Each part, (faces, material), is a surface of its own."""
        mesh = self.add("meshes", {"name": name, "primitives": [self.primitive(*part) for part in parts]})
        self.node({"name": name, "mesh": mesh, **placement})

    def camera(self, name, position, look_at, fov_degrees, aspect):
        camera = self.add("cameras", {"name": name, "type": "perspective", "perspective": {
            "yfov": math.radians(fov_degrees), "aspectRatio": aspect, "znear": 0.01}})
        self.node({"name": name, "camera": camera, "rotation": rotation_to(subtract(look_at, position)),
                   "translation": list(position)})

    def spot(self, name, position, look_at, candela, inner_degrees, outer_degrees, spectrum):
        self.use("KHR_lights_punctual")
        lights = self.root.setdefault("extensions", {"KHR_lights_punctual": {"lights": []}})
        lights = lights["KHR_lights_punctual"]["lights"]
        lights.append({"name": name, "type": "spot", "intensity": candela,
                       "spot": {"innerConeAngle": math.radians(inner_degrees),
                                "outerConeAngle": math.radians(outer_degrees)},
                       "extras": {"lumenfarm_spectra": {"emission": spectrum}}})
        self.node({"name": name, "rotation": rotation_to(subtract(look_at, position)), "translation": list(position),
                   "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})

    def write(self, name):
        data = base64.b64encode(self.bytes).decode()
        self.root["buffers"] = [{"byteLength": len(self.bytes), "uri": "data:application/octet-stream;base64," + data}]
        present = {key: value for key, value in self.root.items() if value != []}  # glTF knows no empty lists
        path = pathlib.Path(__file__).with_name(name)
        path.write_text(readable(present) + "\n", encoding="utf-8")


def readable(value, indent=""):
    """JSON whose short values stay on one line."""
    line = json.dumps(value)
    if len(indent) + len(line) <= 116 or not isinstance(value, (dict, list)) or not value:
        return line
    deeper = indent + "  "
    if isinstance(value, dict):
        lines = [f"{deeper}{json.dumps(key)}: {readable(element, deeper)}" for key, element in value.items()]
        return "{\n" + ",\n".join(lines) + "\n" + indent + "}"
    lines, row = [], ""
    for element in value:  # several short elements share a line
        text = readable(element, deeper)
        if row and len(deeper) + len(row) + len(text) + 2 > 116:
            lines.append(deeper + row)
            row = ""
        row = f"{row}, {text}" if row else text
    lines.append(deeper + row)
    return "[\n" + ",\n".join(lines) + "\n" + indent + "]"


# ---- Vectors and shapes ---------------------------------------------------------------------------------------------

def subtract(a, b): return tuple(p - q for p, q in zip(a, b))
def along(a, b, t): return tuple(p + t * q for p, q in zip(a, b))
def dot(a, b): return sum(p * q for p, q in zip(a, b))
def normalize(a): return tuple(p / math.sqrt(dot(a, a)) for p in a)
def cross(a, b): return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def rotation_to(direction):
    """Quaternion x, y, z, w of a node whose -Z looks along `direction`, its X level."""
    back = normalize(tuple(-c for c in direction))
    right = normalize(cross((0, 1, 0), back))
    m = (right, cross(back, right), back)  # columns
    w = math.sqrt(max(0.0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2
    x = math.copysign(math.sqrt(max(0.0, 1 + m[0][0] - m[1][1] - m[2][2])) / 2, m[1][2] - m[2][1])
    y = math.copysign(math.sqrt(max(0.0, 1 - m[0][0] + m[1][1] - m[2][2])) / 2, m[2][0] - m[0][2])
    z = math.copysign(math.sqrt(max(0.0, 1 - m[0][0] - m[1][1] + m[2][2])) / 2, m[0][1] - m[1][0])
    return [x, y, z, w]


def quad(origin, u, v):
    """A parallelogram whose front is towards u x v."""
    return [origin, along(origin, u, 1), along(along(origin, u, 1), v, 1), along(origin, v, 1)]


def box_sides(x, y, z):
    """The five faces of a box that stands on the floor, by name."""
    return {"top": quad((-x, y, z), (2 * x, 0, 0), (0, 0, -2 * z)), "front": quad((-x, 0, z), (2 * x, 0, 0), (0, y, 0)),
            "right": quad((x, 0, z), (0, 0, -2 * z), (0, y, 0)), "back": quad((x, 0, -z), (-2 * x, 0, 0), (0, y, 0)),
            "left": quad((-x, 0, -z), (0, 0, 2 * z), (0, y, 0))}


def cylinder(radius, height, segments):
    """Side faces, and the top."""
    def rim(i, y):
        angle = 2 * math.pi * (i % segments) / segments
        return (radius * math.cos(angle), y, -radius * math.sin(angle))
    side = [[rim(i, 0), rim(i + 1, 0), rim(i + 1, height), rim(i, height)] for i in range(segments)]
    return side, [[rim(i, height) for i in range(segments)]]


def ball(radius, subdivisions):
    """An icosahedron whose faces are split in four `subdivisions` times and blown up to a sphere."""
    g = (1 + math.sqrt(5)) / 2
    p = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1),
         (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
             (8, 6, 7), (9, 8, 1)]
    faces = [[normalize(p[i]) for i in face] for face in faces]
    for _ in range(subdivisions):
        split = []
        for a, b, c in faces:
            ab, bc, ca = (normalize(tuple(s + t for s, t in zip(*pair))) for pair in ((a, b), (b, c), (c, a)))
            split += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        faces = split
    return [[tuple(radius * c for c in corner) for corner in face] for face in faces]


# ---- The Cornell box ------------------------------------------------------------------------------------------------

# Cornell University Program of Computer Graphics, the Cornell box: reflectances each 4 nm from 400 to 700 nm.
WHITE = """.343 .445 .551 .624 .665 .687 .708 .723 .715 .710 .745 .758 .739 .767 .777 .765 .751 .745 .748 .729 .745 .757
.753 .750 .746 .747 .735 .732 .739 .734 .725 .721 .733 .725 .732 .743 .744 .748 .728 .716 .733 .726 .713 .740 .754 .764
.752 .736 .734 .741 .740 .732 .745 .755 .751 .744 .731 .733 .744 .731 .712 .708 .729 .730 .727 .707 .703 .729 .750 .760
.751 .739 .724 .730 .740 .737"""
GREEN = """.092 .096 .098 .097 .098 .095 .095 .097 .095 .094 .097 .098 .096 .101 .103 .104 .107 .109 .112 .115 .125 .140
.160 .187 .229 .285 .343 .390 .435 .464 .472 .476 .481 .462 .447 .441 .426 .406 .373 .347 .337 .314 .285 .277 .266 .250
.230 .207 .186 .171 .160 .148 .141 .136 .130 .126 .123 .121 .122 .119 .114 .115 .117 .117 .118 .120 .122 .128 .132 .139
.144 .146 .150 .152 .157 .159"""
RED = """.040 .046 .048 .053 .049 .050 .053 .055 .057 .056 .059 .057 .061 .061 .060 .062 .062 .062 .061 .062 .060 .059
.057 .058 .058 .058 .056 .055 .056 .059 .057 .055 .059 .059 .058 .059 .061 .061 .063 .063 .067 .068 .072 .080 .090 .099
.124 .154 .192 .255 .287 .349 .402 .443 .487 .513 .558 .584 .620 .606 .609 .651 .612 .610 .650 .638 .627 .620 .630 .628
.642 .639 .657 .639 .635 .642"""
LAMP = [[400, 0], [500, 8], [600, 15.6], [700, 18.4]]
LAMP_LUMINANCE_CD_M2 = 10000  # ours: some hundreds of lux on the floor
LAMP_BELOW_CEILING_MM = 0.5


def table(text):
    return [[400 + 4 * i, float(value)] for i, value in enumerate(text.split())]


def millimetres(*corners):
    return [tuple(c / 1000 for c in corner) for corner in corners]


def cornell_box(title):
    gltf = Gltf(title)
    white = gltf.material("white", (.72, .71, .68), spectra={"diffuse": table(WHITE)})
    green = gltf.material("green", (.15, .48, .09), spectra={"diffuse": table(GREEN)})
    red = gltf.material("red", (.57, .04, .04), spectra={"diffuse": table(RED)})
    lamp = gltf.material("lamp", (.78, .78, .78), emissive=(1, .7, .3),
                         spectra={"diffuse": [[400, .78], [700, .78]], "emission": LAMP,
                                  "luminance_cd_m2": LAMP_LUMINANCE_CD_M2})
    gltf.object("floor", ([millimetres((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))], white))
    gltf.object("ceiling", ([millimetres((556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0))],
                            white))
    gltf.object("back wall", ([millimetres((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2))],
                              white))
    gltf.object("right wall", ([millimetres((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))], green))
    gltf.object("left wall", ([millimetres((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0))],
                              red))
    gltf.object("short block", ([
        millimetres((130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)),
        millimetres((290, 0, 114), (290, 165, 114), (240, 165, 272), (240, 0, 272)),
        millimetres((130, 0, 65), (130, 165, 65), (290, 165, 114), (290, 0, 114)),
        millimetres((82, 0, 225), (82, 165, 225), (130, 165, 65), (130, 0, 65)),
        millimetres((240, 0, 272), (240, 165, 272), (82, 165, 225), (82, 0, 225))], white))
    gltf.object("tall block", ([
        millimetres((423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)),
        millimetres((423, 0, 247), (423, 330, 247), (472, 330, 406), (472, 0, 406)),
        millimetres((472, 0, 406), (472, 330, 406), (314, 330, 456), (314, 0, 456)),
        millimetres((314, 0, 456), (314, 330, 456), (265, 330, 296), (265, 0, 296)),
        millimetres((265, 0, 296), (265, 330, 296), (423, 330, 247), (423, 0, 247))], white))
    y = 548.8 - LAMP_BELOW_CEILING_MM
    gltf.object("lamp", ([millimetres((343, y, 227), (343, y, 332), (213, y, 332), (213, y, 227))], lamp))
    gltf.camera("camera", (.278, .273, -.8), (.278, .273, 0), 39.3, 1)
    return gltf, white


def cornell():
    gltf, _ = cornell_box("The Cornell box")
    gltf.write("cornell.gltf")


def crumbs():
    """The Cornell box with 3,200 small triangles, rough as crumbs, in one corner of the floor."""
    gltf, white = cornell_box("A Cornell box with all detail in one corner")
    side = 40

    def at(i, k):
        return (.556 * (.02 + .12 * i / side), .5488 * (.03 + .01 * ((i * 7 + k * 13) % 5)),
                .5592 * (.02 + .12 * k / side))

    gltf.object("crumbs", ([[at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)]
                            for i in range(side) for k in range(side)], white))
    gltf.write("crumbs.gltf")


# ---- The room of the paper ------------------------------------------------------------------------------------------

def paper_room():
    """17 surfaces: 6 of the room, 2 lights, a mirror, and 3 objects: a box (5), a cylinder (2) and a ball (1)."""
    gltf = Gltf("A room of 17 surfaces with 3 objects, 2 lights and a mirror")
    white = gltf.material("white paint", (.75, .75, .72))
    blue = gltf.material("blue paint", (.25, .35, .6))
    ochre = gltf.material("ochre paint", (.65, .5, .25))
    wood = gltf.material("wood", (.45, .3, .18))
    red = gltf.material("red", (.6, .08, .06))
    green = gltf.material("green", (.12, .42, .14))
    yellow = gltf.material("yellow", (.75, .6, .1))
    silver = gltf.material("silver", (.93, .93, .92), metallic=1, roughness=0)
    above = gltf.material("lamp above", (.8, .8, .8), emissive=(1, .95, .88), spectra={"luminance_cd_m2": 5000})
    right = gltf.material("lamp at the right", (.8, .8, .8), emissive=(1, .78, .5), spectra={"luminance_cd_m2": 3000})
    gltf.object("floor", ([quad((-2, 0, 2), (4, 0, 0), (0, 0, -4))], wood))
    gltf.object("ceiling", ([quad((-2, 3, -2), (4, 0, 0), (0, 0, 4))], white))
    gltf.object("back wall", ([quad((-2, 0, -2), (4, 0, 0), (0, 3, 0))], white))
    gltf.object("front wall", ([quad((2, 0, 2), (-4, 0, 0), (0, 3, 0))], white))
    gltf.object("left wall", ([quad((-2, 0, 2), (0, 0, -4), (0, 3, 0))], blue))
    gltf.object("right wall", ([quad((2, 0, -2), (0, 0, 4), (0, 3, 0))], ochre))
    gltf.object("lamp above", ([quad((-.4, 2.98, -.8), (.8, 0, 0), (0, 0, .8))], above))
    gltf.object("lamp at the right", ([quad((1.98, 1.1, -1.5), (0, 0, .7), (0, .8, 0))], right))
    gltf.object("mirror", ([quad((-1.5, .45, -1.98), (3, 0, 0), (0, 2.05, 0))], silver))
    turn = math.radians(25) / 2
    gltf.object("box", *[([face], yellow) for face in box_sides(.33, .75, .28).values()],
                rotation=[0, math.sin(turn), 0, math.cos(turn)], translation=[-.95, 0, -.75])
    side, top = cylinder(.28, 1.05, 48)
    gltf.object("cylinder", (side, green), (top, white), translation=[.95, 0, -.95])
    gltf.object("ball", (ball(.34, 3), red), translation=[.1, .341, -.3])
    gltf.camera("camera", (-.1, 1.7, 1.9), (0, .95, -1), 58, 4 / 3)
    gltf.write("paper_room.gltf")


# ---- Prism and ball -------------------------------------------------------------------------------------------------

EQUAL_ENERGY = [[380, 1], [780, 1]]
SF11 = {"sellmeier": {"B": [1.73759695, 0.313747346, 1.89878101], "C": [0.013188707, 0.0623068142, 155.23629]}}
BK7 = {"sellmeier": {"B": [1.03961212, 0.231792344, 1.01046945], "C": [0.00600069867, 0.0200179144, 103.560653]}}


def glass(gltf, name, index, ior):
    return gltf.material(name, (1, 1, 1), roughness=0, spectra={"refractive_index": index}, extensions={
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": ior},
        "KHR_materials_volume": {"thicknessFactor": 1}})


def prism():
    """A 60 degree prism of dense flint near minimum deviation throws five narrow beams, stacked, on the screen: yellow
    arrives at right angles, 400 to 700 nm fan out by about 9 degrees. A ball of crown glass focuses another lamp."""
    gltf = Gltf("A prism and a glass ball whose caustics show colours")
    floor = gltf.material("floor", (.5, .5, .5))
    screen = gltf.material("screen", (.85, .85, .85))
    flint = glass(gltf, "SF11", SF11, 1.78472)
    crown = glass(gltf, "BK7", BK7, 1.5168)
    fill = gltf.material("fill lamp", (.8, .8, .8), emissive=(1, 1, 1), spectra={"luminance_cd_m2": 10})
    gltf.object("floor", ([quad((-2, 0, 1.8), (4, 0, 0), (0, 0, -3.3))], floor))
    gltf.object("screen", ([quad((-2, 0, -1.5), (4, 0, 0), (0, 1.8, 0))], screen))
    gltf.object("fill lamp", ([quad((-.5, 2.6, -.5), (1, 0, 0), (0, 0, 1))], fill))

    deviation = 2 * math.asin(1.78472 * math.sin(math.radians(30))) - math.radians(60)  # of the d line, the least
    arriving = (math.sin(deviation), 0, -math.cos(deviation))
    inside = (math.sin(deviation / 2), 0, -math.cos(deviation / 2))  # parallel to the prism's base
    base = (-math.cos(deviation / 2), 0, -math.sin(deviation / 2))  # its outward normal
    centre, side, low, high = (-.9, 0, .3), .3, .002, .62
    apex = along(centre, base, -side / math.sqrt(3))
    middle = along(centre, base, side / (2 * math.sqrt(3)))
    outline = [apex, along(middle, inside, -side / 2), along(middle, inside, side / 2)]
    if cross(subtract(outline[1], outline[0]), subtract(outline[2], outline[0]))[1] < 0:
        outline.reverse()  # counter-clockwise from above
    bottom = [along(p, (0, 1, 0), low) for p in outline]
    top = [along(p, (0, 1, 0), high) for p in outline]
    sides = [[bottom[i], bottom[(i + 1) % 3], top[(i + 1) % 3], top[i]] for i in range(3)]
    gltf.object("prism", ([top, bottom[::-1], *sides], flint))
    entry = along(centre, inside, -side / 3)  # from here the d line runs through the centre
    for i in range(5):
        target = along(entry, (0, 1, 0), .24 + .045 * i)
        gltf.spot(f"beam {i + 1}", along(target, arriving, -1.0), target, 900, .2, .25, EQUAL_ENERGY)

    middle, radius = (.65, .282, -.25), .28
    gltf.object("ball", (ball(radius, 4), crown), translation=list(middle))
    slope = math.radians(36)
    down = (math.cos(slope) * .5, -math.sin(slope), math.cos(slope) * math.sqrt(.75))
    gltf.spot("lamp", along(middle, down, -1.4), middle, 100, 9, 10.5, EQUAL_ENERGY)
    gltf.camera("camera", (.1, 1.35, 3.6), (-.05, .36, -.4), 31, 1.5)
    gltf.write("prism.gltf")


if __name__ == "__main__":
    cornell()
    crumbs()
    paper_room()
    prism()
