"""The moving picture is an SVG without a script that ends where the motion does."""

from xml.etree import ElementTree

import numpy as np

SCRIPT = "moving_picture"

SVG = "{http://www.w3.org/2000/svg}"


def test_arms_and_markers_move_and_stand_at_their_ends(script):
    arm = np.zeros((3, 5, 2))
    arm[..., 1] = -np.linspace(0, 240, 5)
    arm[1:, -1, 0] = 50, 80
    markers = arm[:, -1:, :] + 5.0
    markers[1] = np.nan  # hidden for a moment
    root = ElementTree.fromstring(script.picture([script.Motion("before", "a", arm, markers, np.array([1.0, 2.0, 3.0]))] * 2))
    moving = {parent: parent.findall(f"{SVG}animate") for parent in root.iter() if parent.find(f"{SVG}animate") is not None}
    assert sorted(parent.tag.removeprefix(SVG) for parent in moving) == ["circle"] * 2 + ["line"] * 2 + ["polyline"] * 2
    for parent, animations in moving.items():
        for each in animations:
            values, times = each.get("values").split(";"), each.get("keyTimes").split(";")
            assert len(values) == len(times) == 4
            assert "nan" not in each.get("values")
            assert parent.get(each.get("attributeName")) == values[-1]
    assert not list(root.iter(f"{SVG}script"))
