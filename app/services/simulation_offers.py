"""The ready scenes and instruments: what there is to choose from."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from app.core.errors import WrongUse
from app.simulate.instrument import list_instruments
from app.simulate.scene_file import SceneFile, get_scene, list_scenes
from app.simulate.series import series_of


def list_offers() -> dict[str, list[dict[str, Any]]]:
    """Scenes and instruments by name, in words and numbers."""
    return {
        "scenes": [describe_scene(name, get_scene(name)) for name in list_scenes()],
        "instruments": [
            {
                "name": tool.name,
                "title": tool.title,
                "wavelengths_nm": list(tool.wavelengths_nm),
                "step_deg": tool.step_deg,
                "notes": list(tool.notes),
            }
            for tool in list_instruments()
        ],
    }


def describe_scene(name: str, scene: SceneFile) -> dict[str, Any]:
    """A scene in words, what it says of its scan, and the series that it is for, if any."""
    series = None
    if scene.series is not None:
        values = series_of(scene.series).values
        series = {"path": scene.series.path, "values": list(values)}
    return {
        "name": name,
        "description": scene.description,
        "instrument": scene.instrument,
        "step_deg": scene.step_deg,
        "seed": scene.seed,
        "series": series,
    }


def show_offer(name: str) -> str:
    """The TOML of a ready scene or instrument, to copy and change.

    Raises
    ------
    WrongUse
        There is neither; the hint has all names.
    """
    known = {"scenes": list_scenes(), "instruments": [tool.name for tool in list_instruments()]}
    for folder, names in known.items():
        if name in names:
            return (files("resources") / folder / f"{name}.toml").read_text(encoding="utf-8")
    scenes, instruments = (", ".join(names) for names in known.values())
    raise WrongUse(
        f"There is no ready scene or instrument {name!r}.",
        f"Scenes: {scenes}. Instruments: {instruments}.",
    )
