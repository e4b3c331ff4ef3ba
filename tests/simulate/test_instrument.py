"""Presets against the tables of science.md, and files of users with faults."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.footprint import footprint_axis
from app.simulate.detector import Ideal, record
from app.simulate.instrument import get_instrument, list_instruments, read_instrument
from app.simulate.ranging import PhaseShift, Pulsed, pulsed_ranges
from app.simulate.receiver import range_sigma

PRESETS = files("resources") / "instruments"


def diameter(name, distance):
    """Of the beam, millimetres."""
    bundle = get_instrument(name).bundle
    axis = footprint_axis(distance, 0.0, bundle.exit_diameter / 2, bundle.half_divergence)
    assert 2 * bundle.radius(distance) == pytest.approx(float(axis))
    return 1000 * float(axis)


def respond(name, rho, distance, channel=0):
    detector = get_instrument(name).detector
    strength = detector.range_effect.strength(np.array([distance]), channel)
    return detector.respond(rho * strength, channel).item()


def test_the_presets_there_are():
    names = [instrument.name for instrument in list_instruments()]
    real = ["hds6100", "hsl", "ls880", "ls880_filtered", "salca", "x330"]
    assert names == sorted([*real, "pulsed", "two_colour"])
    for instrument in list_instruments():
        assert get_instrument(instrument.name) == instrument
        assert instrument.title
        assert instrument.notes


@pytest.mark.parametrize(
    ("name", "wavelengths", "exit_mm", "full_mrad"),
    [
        ("ls880", (785,), 3, 2 * np.deg2rad(0.014) * 1000),
        ("x330", (1550,), 2.25, 0.19),
        ("hds6100", (690,), 3, 0.22),
        ("hsl", (564.3, 610.8, 659.9, 720.3, 764.8, 818.0, 878.6, 979.2), 4, 0.349066),
        ("two_colour", (1063, 1545), 3, 2 * np.deg2rad(0.014) * 1000),
        ("pulsed", (1063, 1545), 3, 2 * np.deg2rad(0.014) * 1000),
    ],
)
def test_wavelengths_and_beams(name, wavelengths, exit_mm, full_mrad):
    instrument = get_instrument(name)
    assert instrument.wavelengths_nm == wavelengths
    assert instrument.bundle.exit_diameter == pytest.approx(exit_mm / 1000)
    assert instrument.bundle.half_divergence == pytest.approx(full_mrad / 2000, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "distance", "published_mm", "within"),
    [
        ("ls880", 2.16, 4.056, 0.0005),
        ("x330", 4.4, 3.09, 0.005),
        ("hds6100", 4.4, 3.97, 0.005),
        ("salca", 6.0, 9.5, 0.01),
        ("hsl", 4.0, 5.0, 0.5),
    ],
)
def test_footprints(name, distance, published_mm, within):
    assert diameter(name, distance) == pytest.approx(published_mm, abs=within)


def test_steps():
    assert get_instrument("ls880").step_deg == 0.018
    for name in ("x330", "hds6100"):
        assert np.deg2rad(get_instrument(name).step_deg) * 4.4 == pytest.approx(0.0012, rel=1e-3)
    assert np.deg2rad(get_instrument("salca").step_deg) == pytest.approx(0.001)
    per_cm = 0.01 / (4 * np.deg2rad(get_instrument("hsl").step_deg))
    assert per_cm**2 == pytest.approx(7 * 20, rel=0.01)


def test_ranging():
    limits = {"ls880": 76.0, "x330": 330.0, "hds6100": 76.0}
    for name, farthest in limits.items():
        instrument = get_instrument(name)
        assert isinstance(instrument.ranging, PhaseShift)
        assert instrument.ranging.unambiguous > instrument.receiver.farthest == farthest
    assert get_instrument("ls880").receiver.nearest == 0.6
    for name in ("salca", "hsl"):
        ranging = get_instrument(name).ranging
        assert isinstance(ranging, Pulsed)
        assert ranging.pulse == pytest.approx(0.15, abs=2e-4)
        assert ranging.waveform is not None
    assert get_instrument("hsl").ranging.blend == 0.15
    pulsed = get_instrument("pulsed").ranging
    assert (pulsed.blend, pulsed.pick, pulsed.least) == (0.25, "first", 0.05)
    two_colour = get_instrument("two_colour")
    assert two_colour.ranging == PhaseShift((76.8, 9.6, 1.2))
    assert two_colour.ranging_channel == 1


def test_noise():
    stated = {"ls880": [0.0026, 0.0052], "ls880_filtered": [0.0007, 0.0013]}
    for name, published in stated.items():
        receiver = get_instrument(name).receiver
        sigma = range_sigma(np.array([0.9, 0.1]), np.full(2, 10.0), receiver)
        np.testing.assert_allclose(sigma, published, rtol=1e-9)
        near, far = range_sigma(np.full(2, 0.5), np.array([1.0, 70.0]), receiver)
        assert far / near == pytest.approx(70 ** (2 * receiver.range_noise_power))
    assert get_instrument("ls880").receiver.correlation == "white"
    teaching = get_instrument("two_colour").receiver
    assert teaching.reference is get_instrument("pulsed").receiver.reference is None
    assert (teaching.range_noise, teaching.intensity_noise) == (pytest.approx(0.0007), 0.03)
    assert get_instrument("hsl").receiver.intensity_noise == 0.06
    assert isinstance(get_instrument("hsl").detector, Ideal)


def test_the_filtered_ls880_is_the_ls880_but_for_its_range_noise():
    raw, filtered = get_instrument("ls880"), get_instrument("ls880_filtered")
    own = {name: getattr(raw, name) for name in ("name", "title", "notes")}
    noise = ("range_noise", "range_noise_power", "correlation")
    receiver = replace(filtered.receiver, **{name: getattr(raw.receiver, name) for name in noise})
    assert filtered.receiver.correlation == "filtered"
    assert replace(filtered, receiver=receiver, **own) == raw


@pytest.mark.parametrize(
    ("name", "dark", "saturated"),
    [("ls880", 0, 2047), ("x330", -2048, 2033), ("hds6100", -1228, 2048)],
)
def test_scales(name, dark, saturated):
    scale = get_instrument(name).detector.scale
    assert (scale.dark, scale.saturated, scale.quantum) == (dark, saturated, 1)


def test_the_ls880_reads_panels_as_balduzzi_did():
    assert respond("ls880", 0.99, 3.56) == pytest.approx(1781.45, abs=0.005)
    table = [(0.83, 30.24), (0.8, 27.84), (0.68, 79.07), (0.48, 169.55), (0.22, 399.3)]
    table += [(0.03, 884.93), (0.03, 961.55)]
    away = [1781.45 - respond("ls880", rho, 3.56) - shift for rho, shift in table]
    assert np.abs(away).max() < 52
    assert np.abs(away).mean() < 25
    # Measured from 0.35 to 10 m without a word of saturation, and on the scale at both ends.
    assert respond("ls880", 0.99, 0.6) < 2047
    assert respond("ls880", 0.03, 10.0) > 0


@pytest.mark.parametrize("name", ["x330", "hds6100"])
def test_a_white_panel_somewhat_saturates_where_junttila_scanned_it(name):
    scale = get_instrument(name).detector.scale
    panels = [respond(name, rho, 4.4) for rho in (0.12, 0.25, 0.5, 0.99)]
    assert scale.dark < panels[0] < panels[1] < panels[2] < scale.saturated
    assert 0 < panels[3] - scale.saturated < 0.05 * (scale.saturated - scale.dark)
    instrument = get_instrument(name)
    white = record(
        np.full((500, 1), 0.99),
        np.full(500, 4.4),
        instrument.detector,
        instrument.receiver,
        np.random.default_rng(0),
    )
    assert 0.5 < white.saturated.mean() < 1


def test_salca_has_the_parameters_of_table_iii():
    detector = get_instrument("salca").detector
    at_1545 = (detector.m[1], detector.c[1], detector.k[1])
    at_1063 = (detector.m[0], detector.c[0], detector.k[0])
    assert at_1545 == (137.21, 407.04, 16.83)
    assert at_1063 == (35.19, 342.45, 7.33)
    effect = detector.range_effect
    assert (effect.a, effect.k2, effect.k3) == ((1.98, 1.5), (0.54, 0.18), (0.64, 0.84))
    assert (get_instrument("salca").receiver.nearest, effect.reference) == (2.0, 8.0)
    # The panels at 8 m straddle the knee at DN 350.
    for channel in (0, 1):
        assert respond("salca", 0.02, 8.0, channel) < 350 < respond("salca", 0.9, 8.0, channel)
        assert respond("salca", 1.0, 2.0, channel) < detector.scale.saturated


def test_the_noise_of_salca_gives_the_ndi_its_published_noise():
    instrument = get_instrument("salca")
    share = instrument.receiver.intensity_noise
    random = np.random.default_rng(1)
    near, far = 0.4 * (1 + share * random.standard_normal((2, 50_000)))
    assert ((near - far) / (near + far)).std() == pytest.approx(0.02, abs=0.002)


@pytest.mark.parametrize("name", ["salca", "hsl"])
@pytest.mark.parametrize("rho", [0.9, 0.4, 0.1])
def test_a_waveform_gives_the_reflectance_of_a_panel(name, rho):
    ranging = get_instrument(name).ranging
    random = np.random.default_rng(2)
    samples = ranging.waveform.samples
    returns = [
        pulsed_ranges([6.0], [rho], ranging, random.standard_normal(samples)) for _ in range(300)
    ]
    ranges, energies = np.array([found[0] for found in returns]).T
    assert energies.mean() == pytest.approx(rho, rel=0.01)
    assert energies.std() < 0.02 * rho
    assert ranges.mean() == pytest.approx(6.0, abs=0.001)


def test_unknown_names_are_refused():
    for name in ("ls990", "", "../icons/leafscope", "__init__"):
        with pytest.raises(WrongUse, match="no instrument") as caught:
            get_instrument(name)
        assert "ls880" in caught.value.hint


def write(tmp_path, old="", new="", preset="ls880"):
    text = (PRESETS / f"{preset}.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def test_a_users_file_is_read_as_the_preset_is(tmp_path):
    assert read_instrument(write(tmp_path)) == get_instrument("ls880")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("half_divergence_mrad", 0.2443460952792061),
        ("full_divergence_mrad", 0.4886921905584122),
        ("full_divergence_deg", 0.028),
    ],
)
def test_a_divergence_may_be_full_or_half_in_either_unit(tmp_path, key, value):
    path = write(tmp_path, "half_divergence_deg = 0.014", f"{key} = {value}")
    expected = get_instrument("ls880").bundle.half_divergence
    assert read_instrument(path).bundle.half_divergence == pytest.approx(expected)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[beam]", "[beam]\ncolour = 3", "beam.colour"),
        ('title = "FARO LS880"', "", "lacks the key title"),
        ("step_deg = 0.018", "", "step_deg, step_mrad"),
        ("step_deg = 0.018", "step_deg = 1\nstep_mrad = 1", "step_deg, step_mrad"),
        ("step_deg = 0.018", "step_deg = -1", "step between beams"),
        ("exit_diameter_mm = 3.0", 'exit_diameter_mm = "3"', "beam.exit_diameter_mm"),
        ("exit_diameter_mm = 3.0", "exit_diameter_mm = nan", "beam.exit_diameter_mm"),
        ("exit_diameter_mm = 3.0", "exit_diameter_mm = -1", "beam.exit_diameter_mm"),
        ("exit_diameter_mm = 3.0", "exit_diameter_mm = 1e300", "beam.exit_diameter_mm"),
        ("half_divergence_deg = 0.014", "full_divergence_deg = 10.1", "diverge by 5.05°"),
        ("half_divergence_deg = 0.014", "full_divergence_mrad = nan", "cannot diverge"),
        ("range_noise_at_m = 10.0", "range_noise_at_m = 0", "[receiver]"),
        ("half_divergence_deg = 0.014", "", "half_divergence_deg"),
        (
            "half_divergence_deg = 0.014",
            "half_divergence_deg = 14",
            "[beam]: A beam cannot diverge",
        ),
        ("[beam]", "[beam]\nrays = 0", "beam.rays"),
        ('kind = "phase-shift"', 'kind = "phase"', "ranging.kind"),
        ("[153.6, 9.6, 1.2]", "[153.6, 10, 1.2]", "[ranging]"),
        ("intensity_noise = 0.02", "", "receiver.intensity_noise"),
        ("intensity_noise = 0.02", "intensity_noise = 2", "[receiver]"),
        ("nearest_m = 0.6", "nearest_m = 99", "[receiver]"),
        ('kind = "logarithmic"', 'kind = "log"', "detector.kind"),
        ("a0 = [600.0]", "a0 = [600.0, 600.0]", "[detector]"),
        ("a0 = [600.0]", "a0 = 600.0", "detector.a0"),
        ("saturated = 2047", "saturated = -1", "[detector]"),
        ('kind = "inverse-square"', 'kind = "inverse"', "detector.range_effect.kind"),
        ("reference_m = 3.56", "reference_m = 0", "[detector]"),
        ("[785.0]", "[785.0, 1550.0]", "2 wavelengths"),
        ("[785.0]", "[]", "no wavelength"),
        ("[785.0]", "[-785.0]", "wavelength"),
        ("[785.0]", "[0.785]", "wavelengths_nm"),
        ("[785.0]", "[1e300]", "wavelengths_nm"),
        ("[785.0]", "[nan]", "wavelength"),
        ("[785.0]", "[785.0", "TOML"),
        ("step_deg = 0.018", "step_deg = 0.018\nranging_channel = 1", "ranging channel"),
    ],
)
def test_faults_of_a_file_are_told_in_words(tmp_path, old, new, told):
    with pytest.raises(BadInput) as caught:
        read_instrument(write(tmp_path, old, new))
    assert "mine.toml" in caught.value.what
    assert told in caught.value.what
    assert caught.value.what.endswith(".")
    assert caught.value.hint


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('pick = "all"', 'pick = "all"\nmost = 1000000000', "1000000000 returns"),
        ('pick = "all"', 'pick = "all"\nmost = 16', "16 returns"),
        ("samples = 256", "samples = 4097", "4097 samples"),
    ],
)
def test_a_beam_cannot_be_made_to_fill_the_memory(tmp_path, old, new, told):
    with pytest.raises(BadInput, match=told) as caught:
        read_instrument(write(tmp_path, old, new, "salca"))
    assert r"mine.toml, [ranging]" in caught.value.what


def test_a_wrong_word_is_answered_with_the_right_ones(tmp_path):
    with pytest.raises(BadInput) as caught:
        read_instrument(write(tmp_path, 'kind = "logarithmic"', 'kind = "log"'))
    assert caught.value.hint == "Choose from: ideal, linear, logarithmic, salca."


def test_salca_keeps_to_its_calibrated_ranges(tmp_path):
    with pytest.raises(BadInput, match="from 2 to 60 m"):
        read_instrument(write(tmp_path, "nearest_m = 2.0", "nearest_m = 1.0", "salca"))


def test_files_that_are_no_instruments(tmp_path):
    with pytest.raises(BadInput, match="cannot be read"):
        read_instrument(tmp_path / "missing.toml")
    with pytest.raises(BadInput, match="cannot be read"):
        read_instrument(tmp_path)
    path = tmp_path / "junk.toml"
    for content in (b"\xff\xfe", b"a=" + b"[" * 20_000, b"", b"#" * 200_000):
        path.write_bytes(content)
        with pytest.raises(BadInput, match=r"junk\.toml"):
            read_instrument(path)


@pytest.mark.parametrize("pair", [(1550.1, 1550.4), (1549.5, 1550.5), (785.0, 785.0)])
def test_wavelengths_of_one_name_are_refused(pair):
    instrument = get_instrument("two_colour")
    with pytest.raises(WrongUse, match=f"2 wavelengths of two_colour are {pair[0]:.0f} nm"):
        replace(instrument, wavelengths_nm=pair)
    assert replace(instrument, wavelengths_nm=(1549.0, 1550.0)).wavelengths_nm == (1549.0, 1550.0)
