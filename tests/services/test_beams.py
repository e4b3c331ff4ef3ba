"""Where the beam of a scanner may come from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.model.parameters import Beam
from app.model.scan import Scan
from app.services.beams import (
    beam_of_instrument,
    choose_beam,
    describe_beam,
    list_beams,
    propose_beam,
)
from app.services.simulation_offers import show_offer


def name(**metadata: str) -> Scan:
    return Scan("s", np.zeros((1, 3)), metadata=metadata)


def test_the_ls880_as_its_file_says() -> None:
    beam = beam_of_instrument("ls880")
    assert beam.radius == pytest.approx(0.0015)
    assert np.rad2deg(beam.half_divergence) == pytest.approx(0.014)
    assert describe_beam(beam) == "3 mm at exit, half divergence 0.014° (instrument ls880)"


def test_an_instrument_of_ones_own(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(show_offer("ls880").replace("exit_diameter_mm = 3.0", "exit_diameter_mm = 5.0"))
    assert beam_of_instrument(str(file)).radius == pytest.approx(0.0025)


def test_two_numbers_make_a_beam() -> None:
    beam = choose_beam(None, 3.0, 0.014)
    assert beam == Beam(0.0015, np.deg2rad(0.014), "typed in")
    assert choose_beam(None, None, None) is None


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ((None, 3.0, None), "both --exit-diameter"),
        ((None, None, 0.014), "both --exit-diameter"),
        (("ls880", 3.0, None), "not by both"),
        (("ls99", None, None), "no instrument 'ls99'.*hds6100"),
        ((None, -3.0, 0.014), "radius from 0 m"),
        ((None, 3.0, 90.0), "half angle"),
    ],
)
def test_what_does_not_make_a_beam_is_refused(given: tuple[object, ...], says: str) -> None:
    with pytest.raises(WrongUse, match=says):
        choose_beam(*given)


@pytest.mark.parametrize(
    ("metadata", "instrument"),
    [
        ({"instrument": "simulated: FARO LS880"}, "ls880"),
        ({"instrument": "simulated: FARO LS880, filtered"}, "ls880_filtered"),
        ({"sensorVendor": "FARO", "sensorModel": "Focus X330"}, "x330"),
        ({"system": "SALCA"}, "salca"),
        ({"sensorVendor": "FARO"}, None),
        ({"instrument note 1": "unlike the FARO LS880"}, None),
        ({}, None),
    ],
)
def test_a_scan_may_name_its_instrument(metadata: dict[str, str], instrument: str | None) -> None:
    beam = propose_beam(name(**metadata))
    if instrument is None:
        assert beam is None
    else:
        assert beam is not None
        assert beam.origin == f"instrument {instrument}, as the scan says"


def test_every_preset_is_found_by_what_a_simulation_says_of_it() -> None:
    for title, beam in list_beams():
        proposed = propose_beam(name(instrument=f"simulated: {title}"))
        assert proposed is not None
        assert proposed.origin.startswith(f"{beam.origin},")
