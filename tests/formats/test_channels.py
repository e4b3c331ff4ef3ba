"""Channels by names and values."""

from __future__ import annotations

import numpy as np
import pytest

from app.formats.channels import recognise_channels

RAMP = np.linspace(0.0, 1.0, 50)


@pytest.mark.parametrize(
    ("name", "values", "wavelength", "kind"),
    [
        ("reflectance_1063", RAMP, 1063.0, "reflectance"),
        ("reflectance_1063", RAMP * 100, 1063.0, "DN"),
        ("reflectance_1550", RAMP * 20 - 15, 1550.0, "dB"),
        ("intensity_1545", RAMP * 4000, 1545.0, "DN"),
        ("Intensity1545nm", RAMP * 4000, 1545.0, "DN"),
        ("intensity 818.5", RAMP, 818.5, "DN"),
        ("Reflectance", RAMP * 20 - 15, None, "dB"),
        ("Reflectance (dB)", RAMP, None, "dB"),
        ("Amplitude", RAMP * 40, None, "dB"),
        ("amplitude", RAMP * 40000, None, "DN"),
        ("intensity", (RAMP * 2000).astype(np.uint16), None, "DN"),
        ("scalar_Intensity", RAMP, None, "DN"),
        ("intensity_2", RAMP, None, "DN"),
        ("reflectance_1063", np.where(RAMP > 0.5, np.nan, RAMP), 1063.0, "reflectance"),
    ],
)
def test_channel(name: str, values: np.ndarray, wavelength: float | None, kind: str) -> None:
    (channel,) = recognise_channels({name: values})
    assert (channel.name, channel.attribute) == (name, name)
    assert channel.wavelength_nm == wavelength
    assert channel.kind == kind


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("intensity", np.zeros(9, np.uint16)),
        ("intensity", np.full(9, np.nan)),
        ("intensity", np.empty(0)),
        ("incidence_from_intensity", RAMP),
        ("Deviation", RAMP),
        ("intensity", np.array(["a", "b"])),
    ],
)
def test_no_channel(name: str, values: np.ndarray) -> None:
    assert recognise_channels({name: values}) == ()
