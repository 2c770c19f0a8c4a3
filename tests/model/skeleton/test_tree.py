"""What is no tree of links and joints is one sentence."""

import re

import pytest

from hillobs.model.skeleton.tree import GROUND, Joint, Link, Tree, TreeError

ROD = Link(1.0, (0.0, -0.2, 0.0), (0.02, 0.001, 0.02, 0, 0, 0))

WRONG = [
    ({"a": ROD}, {}, "link a hangs in no joint; each link is the child of one"),
    ({"a": ROD}, {"j": Joint("b", "a")}, "joint j: its parent 'b' is no link; there are ground, a"),
    ({"a": ROD}, {"j": Joint(GROUND, "b")}, "joint j: its child 'b' is no link; there are a"),
    ({"a": ROD}, {"j": Joint(GROUND, GROUND)}, "joint j: its child 'ground' is no link; there are a"),
    ({"a": ROD}, {"j": Joint(GROUND, "a"), "k": Joint(GROUND, "a")}, "link a hangs in two joints, j and k"),
    ({"a": ROD, "b": ROD}, {"j": Joint("b", "a"), "k": Joint("a", "b")}, "links hang in a circle: a → b → a"),
    ({"a": ROD}, {"j": Joint("a", "a")}, "links hang in a circle: a → a"),
    ({"a": ROD}, {"j": Joint(GROUND, "a", axis=(0, 0, 0))}, "joint j: its axis is 0 0 0, which has no direction"),
    ({"a": ROD}, {"j": Joint(GROUND, "a", kind="ball")}, "joint j: its type is one of pin, slider, weld, not 'ball'"),
    ({"a": ROD}, {"j": Joint(GROUND, "a", range=(1, 1))}, "joint j: its range must rise, not go from 1 to 1"),
    ({"a": Link(1, inertia=(1, 1, 1))}, {"j": Joint(GROUND, "a")}, "link a: its inertia has 6 numbers, xx, yy, zz,"),
    ({"a": Link(1, inertia=(1, 1, -1, 0, 0, 0))}, {"j": Joint(GROUND, "a")}, "link a: its inertia is not positive"),
    ({"a": Link(1, inertia=(1, 1, 1, 2, 0, 0))}, {"j": Joint(GROUND, "a")}, "link a: its inertia is not positive"),
]


@pytest.mark.parametrize(("links", "joints", "sentence"), WRONG, ids=[sentence for *_, sentence in WRONG])
def test_it_is_refused(links, joints, sentence: str) -> None:
    with pytest.raises(TreeError, match=re.escape(sentence)):
        Tree(links, joints)
