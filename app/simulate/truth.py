"""What is known about every simulated point, as fields of the scan."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.units import to_degrees
from app.simulate.scanner import Echoes
from app.simulate.surfaces import Scene
from app.simulate.tables import tabulate_optics

GHOST = 0.006
"""A range farther than this, metres, from all that the beam touched is a ghost."""
UNSURE = 0.002


def tell_truth(scene: Scene, echoes: Echoes, sigma_range: Floats) -> dict[str, AnyArray]:
    """Fields of every return, in the order of `echoes`.

    Returns
    -------
    dict of str to (n,) array
        - ``truth_leaf`` int32, −1 on stems and walls: leaf of the main surface, the one that sends
          back most in the ranging channel;
        - ``truth_incidence`` degrees, there;
        - ``truth_normal_x``, ``_y``, ``_z`` unit normal of the facet there, facing the scanner;
        - ``truth_surface``, ``truth_surface_2``, ``_3`` int32 surfaces of the components, main
          first, −1 none;
        - ``truth_hit_fraction``, ``truth_hit_fraction_2``, ``_3`` their shares of the beam;
        - ``truth_components`` how many surfaces the return is made of (more than three happen);
        - ``truth_range`` that the instrument would report without noise, metres;
        - ``truth_distance`` from there to the nearest surface that the beam touched, metres;
        - ``truth_range_shift``, truth_range minus the energy-weighted range of the main
          surface, metres;
        - ``truth_ghost`` 1: truth_distance > 6 mm; 2: unsure, 2 to 6 mm; 0: on a surface;
        - ``truth_rho_<nm>`` reflectance of the surface at ω = 0, ``truth_reflectance_<nm>`` at
          truth_incidence, for a full hit;
        - ``truth_sigma_range`` σ of the range noise, metres.
    """
    off, main = echoes.off_surface, echoes.surface[:, 0]
    truth: dict[str, AnyArray] = {
        "truth_leaf": scene.labels()[main] if len(main) else np.empty(0, np.int32),
        "truth_incidence": to_degrees(echoes.incidence).astype(np.float32),
        "truth_ghost": np.where(off > GHOST, 1, np.where(off > UNSURE, 2, 0)).astype(np.uint8),
        "truth_range": echoes.distance,
        "truth_distance": off.astype(np.float32),
        "truth_range_shift": echoes.shift.astype(np.float32),
        "truth_components": np.minimum(echoes.touched, 255).astype(np.uint8),
        "truth_sigma_range": sigma_range.astype(np.float32),
    }
    for k, tail in enumerate(("", "_2", "_3")):
        truth[f"truth_surface{tail}"] = echoes.surface[:, k]
        truth[f"truth_hit_fraction{tail}"] = echoes.share[:, k].astype(np.float32)
    for k, axis in enumerate("xyz"):
        truth[f"truth_normal_{axis}"] = echoes.normal[:, k].astype(np.float32)
    return truth | _tell_reflectance(scene, echoes)


def _tell_reflectance(scene: Scene, echoes: Echoes) -> dict[str, AnyArray]:
    optics = tabulate_optics(scene)
    place = np.sqrt(np.maximum(1 - np.cos(echoes.incidence), 0.0))
    samples = np.linspace(0.0, 1.0, optics.curves.shape[1])
    main, found = echoes.surface[:, 0], {}
    for k, nm in enumerate(scene.wavelengths_nm):
        rho, row = optics.rho[main, k], optics.curve[main, k]
        phase = np.empty(len(main))
        for index in np.unique(row):
            mine = row == index
            phase[mine] = np.interp(place[mine], samples, optics.curves[index])
        found[f"truth_rho_{nm:.0f}"] = rho.astype(np.float32)
        found[f"truth_reflectance_{nm:.0f}"] = (rho * phase).astype(np.float32)
    return found


def name_surfaces(scene: Scene) -> dict[str, str]:
    """What the numbers in ``truth_surface`` mean, for the scan's metadata."""
    leaves, stems = len(scene.leaves), len(scene.stems)
    names = {
        "truth_surface 0 to": f"{leaves - 1}: leaves" if leaves else "",
        f"truth_surface {leaves} to": f"{leaves + stems - 1}: stems" if stems else "",
    }
    for k, wall in enumerate(scene.walls):
        names[f"truth_surface {leaves + stems + k}"] = wall.name
    return {key: text for key, text in names.items() if text}
