"""A user's own formula models: TOML files in a folder of the user's, beside the registry."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec
import platformdirs

from app.core.errors import BadInput, LeafscopeError, WrongUse
from app.core.formula_syntax import channels_of, parse
from app.core.phase import MODELS, PhaseModel
from app.core.phase.angular import AngularModel
from app.core.phase.formula_model import (
    OMEGA,
    FormulaDefinition,
    FormulaModel,
    make_formula_model,
)
from app.formats.atomic import atomic_path
from app.simulate.ready_files import read_start

AnyModel = PhaseModel | FormulaModel | FormulaDefinition | str
FOLDER = "LEAFSCOPE_MODELS"
"""Variable that names another folder than the usual one."""
LARGEST, MOST_FILES, LONGEST_NAME, LONGEST_WORD = 64_000, 200, 60, 200
ENDING = ".toml"
EXAMPLE = (
    "A model needs name, expression (in omega, radians) and [[parameters]] with name and typical"
    " = [low, high]."
)


@dataclass(frozen=True, slots=True)
class OwnModels:
    """Models of a folder by name, and a sentence for each file that is none."""

    models: Mapping[str, FormulaDefinition]
    faults: tuple[str, ...] = ()


def own_folder() -> Path:
    """Where the user's models are; it may not exist yet."""
    return Path(os.environ.get(FOLDER) or Path(platformdirs.user_data_dir("leafscope")) / "models")


def find_model(model: AnyModel, folder: Path | None = None) -> PhaseModel | FormulaModel:
    """A model by name (of the registry, else the user's own), of a definition, or itself.

    Raises
    ------
    WrongUse
        There is none of that name, or the definition cannot be.
    """
    if isinstance(model, FormulaDefinition):
        return check_definition(model)
    if not isinstance(model, str):
        return model
    if model in MODELS:
        return MODELS[model]
    own = list_own(folder).models
    if model in own:
        return make_formula_model(own[model])
    raise WrongUse(f"There is no model {model!r}.", f"Models: {', '.join((*MODELS, *own))}.")


def models_at_hand(folder: Path | None = None) -> dict[str, AngularModel]:
    """The models of the registry, then the user's own, by name."""
    own = {name: make_formula_model(d) for name, d in list_own(folder).models.items()}
    return {**MODELS, **own}


def list_own(folder: Path | None = None) -> OwnModels:
    """Read the user's models; a file that is none is told and left."""
    folder = folder or own_folder()
    models: dict[str, FormulaDefinition] = {}
    faults: list[str] = []
    files = _list_files(folder)
    for file in files[:MOST_FILES]:
        try:
            definition = read_model(file)
        except LeafscopeError as error:
            faults.append(str(error))
            continue
        if definition.name in models:
            faults.append(f"{file.name} holds {definition.name}, which another file holds too.")
        models.setdefault(definition.name, definition)
    if len(files) > MOST_FILES:
        faults.append(f"{folder} holds more than {MOST_FILES} models; the others are left out.")
    return OwnModels(dict(sorted(models.items())), tuple(faults))


def save_own(
    definition: FormulaDefinition, overwrite: bool = False, folder: Path | None = None
) -> Path:
    """Keep a model among the user's own; give its file.

    Raises
    ------
    WrongUse
        The definition cannot be.
    BadInput
        There is one of that name already, or the folder cannot be written to.
    """
    folder = folder or own_folder()
    check_definition(definition)
    path = _find_file(definition.name, folder)
    if path is not None and not overwrite:
        raise BadInput(f"There is a model {definition.name} already.", "Choose another name.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"The folder {folder} cannot be made: {error.strerror}.") from error
    path = path or _name_file(definition.name, folder)
    write_model(definition, path, overwrite=True)
    return path


def delete_own(name: str, folder: Path | None = None) -> None:
    """Remove one of the user's models; curves and fits made with it keep its formula."""
    folder = folder or own_folder()
    path = _find_file(name, folder)
    if path is None:
        raise WrongUse(f"There is no model {name!r} in {folder}.")
    try:
        path.unlink()
    except OSError as error:
        raise BadInput(f"{path} cannot be removed: {error.strerror or error}.") from error


def read_model(path: str | Path) -> FormulaDefinition:
    """Read a model from a TOML file and check it.

    Raises
    ------
    BadInput
        The file cannot be read, is too large, not TOML, or holds no formula model that can be.
    """
    path = Path(path)
    content = read_start(path, LARGEST, "model")
    if len(content) > LARGEST:
        raise BadInput(f"{path.name} is too large for a model.", "Choose another file.")
    try:
        definition = msgspec.toml.decode(content, type=FormulaDefinition)
        check_definition(definition)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise BadInput(f"{path.name} holds no formula model: {error}.", EXAMPLE) from error
    except LeafscopeError as error:
        raise BadInput(f"{path.name}: {error.what}", error.hint or EXAMPLE) from error
    return definition


def write_model(definition: FormulaDefinition, path: str | Path, overwrite: bool = False) -> None:
    """Write a model as TOML, whole or not at all."""
    import tomli_w

    plain = msgspec.to_builtins(definition)
    for parameter in plain["parameters"]:
        for bound in ("lower", "upper"):
            if parameter[bound] is None:  # TOML has no null
                del parameter[bound]
    with atomic_path(Path(path), overwrite) as temporary:
        temporary.write_bytes(tomli_w.dumps(plain).encode())


def check_definition(definition: FormulaDefinition) -> FormulaModel:
    """Make a model of a definition; raises `WrongUse` with the reason where it cannot be."""
    if len(definition.name) > LONGEST_NAME or not definition.name.isprintable():
        raise WrongUse(f"The name of a model has 1 to {LONGEST_NAME} characters to read.")
    for p in definition.parameters:
        if max(len(p.name), len(p.unit), len(p.meaning)) > LONGEST_WORD:
            raise WrongUse(f"The words of {p.name[:20]} are too long.")
    try:
        return make_formula_model(definition)
    except LeafscopeError as error:
        raise WrongUse(error.what, error.hint) from error


def names_in(expression: str) -> tuple[str, ...]:
    """The parameters that an expression names, in their order; raises `WrongUse` as the parser."""
    names = (node.id for node in channels_of(parse(expression)))
    return tuple(dict.fromkeys(name for name in names if name != OMEGA))


def _list_files(folder: Path) -> list[Path]:
    files = folder.glob(f"*{ENDING}") if folder.is_dir() else ()
    return sorted(file for file in files if file.is_file())


def _find_file(name: str, folder: Path) -> Path | None:
    """The file that holds a model of that name, whatever it is called."""
    for file in _list_files(folder):
        try:
            if read_model(file).name == name:
                return file
        except BadInput:
            continue  # it holds no model, so not this one
    return None


def _name_file(name: str, folder: Path) -> Path:
    """A file for a new model, never one that exists."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-") or "model"
    taken = {file.name.lower() for file in folder.iterdir()}
    number, file = 1, f"{stem}{ENDING}"
    while file.lower() in taken:
        number += 1
        file = f"{stem}-{number}{ENDING}"
    return folder / file
