"""Profiles as files: what is written comes back, and hostile files give a sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.radiometry.drift import Power
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.profile import ChannelCalibration, Evidence, Noise, Profile
from app.core.radiometry.range_curve import PolynomialCurve
from app.services.profiles import (
    decode_profile,
    encode_profile,
    find_profile,
    list_profiles,
    read_profile,
    write_profile,
)

CURVE = PolynomialCurve("additive", (1.0, 3.56, 10.0), (0.1 + 0.2, 0.0, -1 / 3), 3.56, 2)
CHANNEL = ChannelCalibration(
    "intensity_785",
    (Power(1.0), LogResponse(600.0, 1781.45), CURVE),
    785.0,
    dark=0.0,
    saturated=2047.0,
    nearest=1.0,
    farthest=10.0,
    reflectances=(0.03, 0.99),
    noise=Noise(3.0, 0.001),
    fit_covariance=tuple(tuple(float(i * 5 + j) / 7 for j in range(5)) for i in range(5)),
    evidence=Evidence(12, 1, ("a", "b"), 0.01, -0.001),
)
PROFILE = Profile("mine", (CHANNEL,), "ls880", notes=('a "quoted" ρ = ½',))


def test_what_is_written_comes_back_bit_by_bit(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    write_profile(PROFILE, path)
    assert read_profile(path) == PROFILE
    assert find_profile(str(path)) == PROFILE
    with pytest.raises(BadInput, match="exists already"):
        write_profile(PROFILE, path)
    write_profile(PROFILE, path, overwrite=True)
    assert [each.name for each in tmp_path.iterdir()] == ["mine.toml"]


def test_the_published_profiles_are_all_readable() -> None:
    found = list_profiles()
    assert len(found) >= 2
    assert all(profile.origin == "published" for profile in found)
    assert find_profile("salca").instrument == "salca"


def test_an_unknown_profile_is_told_with_those_there_are() -> None:
    with pytest.raises(BadInput, match=r"no profile nowhere.*salca"):
        find_profile("nowhere")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('name = "mine"', "", r"lacks the key name"),
        ('name = "mine"', 'name = "mine"\ncolour = 1', r"key colour, which no profile has"),
        ("a0 = 600.0", "a0 = -600.0", r"p.toml.*positive a0"),
        ("a0 = 600.0", 'a0 = "x"', r"key channels\[0\].steps\[1\].a0: expected float"),
        ('step = "log-response"', 'step = "magic"', r"p.toml, key channels\[0\].steps.*magic"),
        ("value = 1.0", "value = nan", r"power of a scan must be a positive"),
        ("wavelength_nm = 785.0", "wavelength_nm = -1.0", "wavelength"),
        ("order = 2", "order = 3", "order"),
        ("reference = 3.56", "reference = 4.0", "reference range of 4 m"),
        ("constant = 3.0", "constant = inf", "noise of a channel"),
        ("name", "name = = ", "is not a TOML file"),
    ],
)
def test_hostile_profiles_give_a_sentence(old: str, new: str, words: str) -> None:
    text = encode_profile(PROFILE).decode()
    assert old in text
    with pytest.raises(BadInput, match=words):
        decode_profile(text.replace(old, new, 1).encode(), "p.toml")


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe",
        b"[" * 100_000,
        b"a = 1\n" * 10,
        b"x" * 5_000_000,
        b"channels = []\nname='a'",
    ],
)
def test_rubbish_is_refused(content: bytes) -> None:
    with pytest.raises(BadInput, match=r"p\.toml"):
        decode_profile(content, "p.toml")


def test_damaged_profiles_never_end_otherwise() -> None:
    random = np.random.default_rng(3)
    whole = np.frombuffer(encode_profile(PROFILE), np.uint8)
    for _ in range(300):
        content = whole.copy()
        where = random.integers(len(content), size=3)
        content[where] = random.integers(32, 127, size=3)
        try:
            decode_profile(content.tobytes(), "p.toml")
        except BadInput as error:
            told = str(error)
            assert "p.toml" in told or "profile" in told
