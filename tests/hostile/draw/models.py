"""OpenSim models: a good one, what may be wrong with its XML, its numbers and its names, and what is asked of it."""

from __future__ import annotations

import re
from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name, odd_out
from hostile.draw.numbers import number

FILE, _OUT = "model.osim", "arm.toml"
_MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="40600">
<Model name="hinge">
<gravity>0 -9.80665 0</gravity>
<BodySet><objects><Body name="forearm"><mass>1.5</mass><mass_center>0 -0.18 0</mass_center>
<inertia>0.019 0.0016 0.02 0 0 0</inertia></Body></objects></BodySet>
<JointSet><objects><PinJoint name="elbow"><socket_parent_frame>/ground</socket_parent_frame>
<socket_child_frame>forearm_offset</socket_child_frame>
<coordinates><Coordinate name="flexion"><range>0.1 2.2</range></Coordinate></coordinates>
<frames><PhysicalOffsetFrame name="forearm_offset"><socket_parent>/bodyset/forearm</socket_parent>
<translation>0 0.01 0</translation><orientation>0 0 0.1</orientation></PhysicalOffsetFrame></frames>
</PinJoint></objects></JointSet>
<ForceSet><objects><Thelen2003Muscle name="BRA"><FunctionBasedPath name="path">
<coordinate_paths>/jointset/elbow/flexion</coordinate_paths><length_function><MultivariatePolynomialFunction>
<coefficients>0.147 -0.017 0.009</coefficients><dimension>1</dimension><order>2</order>
</MultivariatePolynomialFunction></length_function></FunctionBasedPath>
<max_isometric_force>987</max_isometric_force><optimal_fiber_length>0.086</optimal_fiber_length>
<tendon_slack_length>0.054</tendon_slack_length></Thelen2003Muscle></objects></ForceSet>
</Model>
</OpenSimDocument>
"""
_NUMBER = re.compile(r"(?<=[ >])-?[0-9][0-9.]*(?=[ <])")
_ELEMENT = re.compile(r"<(\w+)[^<>]*>[^<>]*</\1>")
_DECLARED = (
    "<!DOCTYPE x>",
    '<!DOCTYPE x SYSTEM "../other/letter.txt">',
    '<!DOCTYPE x [<!ENTITY a SYSTEM "../other/letter.txt">]>',
    '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>',
)
_WORDS = (
    "elbow",
    "flexion",
    "forearm",
    "ground",
    "",
    "\u202eflexion",
    "a b",
    "&#27;[31m",
    "&lt;",
    "&a;",
    "ü😀",
    "[red]",
)


def model(random: Random) -> Layer:
    """A good model, and where the mechanism will be."""
    out = ["--out", _OUT] if random.random() < 0.7 else []
    return {"words": [FILE, *out], "files": {FILE: {"text": _MODEL}}}


def changed(random: Random) -> Layer:
    """The model with a number, a name or an element that is wrong or missing, or with a document type."""
    text = _MODEL
    match random.random():
        case share if share < 0.4:
            found = random.choice(list(_NUMBER.finditer(text)))
            text = text[: found.start()] + number(random, float(found[0])) + text[found.end() :]
        case share if share < 0.6:
            found = random.choice(list(_ELEMENT.finditer(text)))
            text = text[: found.start()] + random.choice(("", found[0] * 2)) + text[found.end() :]
        case share if share < 0.8:
            name = random.choice(("elbow", "flexion", "forearm", "BRA", "PinJoint", "Thelen2003Muscle"))
            text = text.replace(name, random.choice(_WORDS), random.choice((1, 1, 9)))
        case share if share < 0.9:
            text = text.replace("<OpenSim", f"{random.choice(_DECLARED)}<OpenSim", 1).replace("hinge", "&a;")
        case _:
            text = text[: random.randrange(len(text))]
    return {"files": {FILE: {"text": text}}}


def option(random: Random) -> Layer:
    """What is asked of the model, or a file of paths."""
    name = random.choice(("elbow", "flexion", "elbow", "wrist", "", "\x1b[31m"))
    match random.choice(("lock", "range", "muscles", "paths", "order")):
        case "lock":
            return {"words": ["--lock", f"{name}={number(random, 0.5)}"]}
        case "range":
            return {"words": ["--range", f"{name}={number(random, 0.1)}:{number(random, 2.2)}"]}
        case "muscles":
            return {"words": ["--muscles", random.choice(("BRA", "BRA,BRA", "TRI", ",", "BRA, ", "\x1b"))]}
        case "paths":
            return {"words": ["--paths", random.choice((FILE, "no.xml", "../other/letter.txt", "."))]}
        case _:
            return {"words": ["--order", number(random, 5)]}


def odd_file(random: Random) -> Layer:
    """The model under an odd name, or something else in its place."""
    return odd_name(random, FILE) if random.random() < 0.5 else odd_kind(random, FILE)


def out(random: Random) -> Layer:
    """Something in the way of the mechanism."""
    return {"words": ["--out", _OUT], **odd_out(random, _OUT)}
