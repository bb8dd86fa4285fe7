# SPDX-License-Identifier: Apache-2.0
"""A picture file as raw pixels, for messages that carry nothing else."""

from __future__ import annotations

import io

import pytest

from rai_missions.errors import ConnectorError
from rai_missions.image import Image, png
from rai_missions.tools.images import pixels_of

PIL = pytest.importorskip("PIL.Image", reason="pip install pillow")
RGB = bytes(range(18))


def test_a_png_keeps_every_pixel_and_raw_pixels_are_left_alone() -> None:
    made = pixels_of(Image.of_file("camera", png(3, 2, RGB)))
    assert (made.ref, made.width, made.height, made.encoding, made.data) == ("camera", 3, 2, "rgb8", RGB)
    assert pixels_of(made) is made


def test_a_jpeg_has_its_size() -> None:
    file = io.BytesIO()
    PIL.frombytes("RGB", (3, 2), RGB).save(file, "JPEG")
    made = pixels_of(Image.of_file("camera", file.getvalue()))
    assert (made.width, made.height, len(made.data)) == (3, 2, 18)


def test_a_file_that_is_cut_short_or_too_large_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = png(300, 200, bytes(300 * 200 * 3))
    with pytest.raises(ConnectorError, match="a picture file of 26 bytes cannot be opened"):
        pixels_of(Image("camera", 300, 200, "png", whole[:26]))
    with pytest.raises(ConnectorError, match="cannot be opened"):
        pixels_of(Image("camera", 300, 200, "png", whole[: len(whole) // 2]))
    monkeypatch.setattr("rai_missions.tools.images.MOST_PIXELS", 59_999)
    with pytest.raises(ConnectorError, match="a picture of 300x200 is too large; 59999 pixels are the most"):
        pixels_of(Image("camera", 300, 200, "png", whole))
