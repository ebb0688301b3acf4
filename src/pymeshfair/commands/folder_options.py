"""Options that are typed every time, from pymeshfair.toml or pyproject.toml of the working folder.

``[tool.pymeshfair]`` of pyproject.toml, or the whole of pymeshfair.toml, gives options to every command that has them; a table in
it with the name of a command, such as ``[tool.pymeshfair.run]``, to that one. What is typed goes first.
"""

import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import typer

OWN, PROJECT = Path("pymeshfair.toml"), Path("pyproject.toml")
#: options that a folder from elsewhere must not set: replaced files, unchecked reading, and the machines that take part
TYPED = ("overwrite", "allow-outside", "unchecked", "keep-broken", "scheduler", "host", "output", "help", "json", "debug")


def folder_options(app: Any) -> dict[str, Any]:
    """By command, its options from the file of the working folder, as click's ``default_map``.

    Raises:
        ParameterError: the file cannot be read, or has what is no option; the message has the line.
    """
    table, file, title = _table()
    return {} if file is None else _values(app, table, file, title, {})


def used_options(options: Mapping[str, Any], arguments: Sequence[str]) -> str:
    """Which options of the file a command line meets, as a sentence for its errors; empty if none."""
    for word in arguments:
        options = options.get(word, options) if isinstance(options.get(word, {}), dict) else options
    values = [f"{name} = {value}" for name, value in options.items() if not isinstance(value, dict)]
    return f"{OWN if OWN.is_file() else PROJECT} has: {', '.join(values)}" if values else ""


def _table() -> tuple[Mapping[str, Any], Path | None, str]:
    for file, keys in ((OWN, ()), (PROJECT, ("tool", "pymeshfair"))):
        if file.is_file():
            table: Any = _parsed(file)
            for key in keys:
                table = table.get(key) if isinstance(table, dict) else None
            if isinstance(table, dict):
                return table, file, ".".join(keys)
    return {}, None, ""


def _parsed(file: Path) -> dict[str, Any]:
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return tomllib.loads(file.read_text("utf-8"))
    except (OSError, ValueError) as error:  # of TOML and of UTF-8 too
        from ..errors import ParameterError

        raise ParameterError(f"{file} cannot be read: {error}; correct it, or move it away") from None


def _values(command: Any, table: Mapping[str, Any], file: Path, title: str, around: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a command, or by name of those of a group: of its table, over those of the tables around it."""
    options, inner = _options(command), getattr(command, "commands", {})
    tables = {name: value for name, value in table.items() if name in inner and isinstance(value, dict)}
    own = {name: value for name, value in table.items() if name not in tables}
    for name in own:
        _check(name, {*options, *inner}, file, title)
    values = {name: value for name, value in {**around, **own}.items() if name in options}
    if not inner:
        return {options[key].name: _value(options[key], command, value, file, key) for key, value in values.items()}
    return {name: _values(one, tables.get(name, {}), file, f"{title}.{name}".lstrip("."), values) for name, one in inner.items()}


def _value(option: Any, command: Any, value: Any, file: Path, key: str) -> Any:
    several = [value] if option.multiple and not isinstance(value, list) else value
    try:
        option.type_cast_value(typer.Context(command), several)
    except typer.BadParameter as error:
        from ..errors import ParameterError

        raise ParameterError(f"{file}{_line(file, key)}: {key}: {error.message}") from None
    return several


def _options(command: Any) -> dict[str, Any]:
    """The options of a command, or of all commands of a group, by their long names."""
    if inner := getattr(command, "commands", None):
        return {name: option for one in inner.values() for name, option in _options(one).items()}
    return {_name(p): p for p in command.params if p.param_type_name == "option" and _name(p) not in TYPED}


def _name(option: Any) -> str:
    return str(max(option.opts, key=len)).lstrip("-")


def _check(key: str, allowed: set[str], file: Path, title: str) -> None:
    if key in allowed:
        return
    from ..declaration import nearest
    from ..errors import ParameterError

    where = f"{file}{_line(file, key)}: {f'[{title}] has ' if title else ''}{key!r}"
    if key in TYPED:
        raise ParameterError(f"{where}, which has to be typed; take it out of the file")
    near = nearest(key, allowed)
    hint = f"did you mean {near!r}?" if near else "`pymeshfair COMMAND --help` lists the options"
    raise ParameterError(f"{where}, which is no option{f' of {title}' if title else ''}; {hint}")


def _line(file: Path, key: str) -> str:
    """The line of the first such key, as it stands in a message."""
    written = re.compile(rf"""\s*(\[.*)?["']?{re.escape(key)}["']?\s*[=\]]""")
    return next((f":{number}" for number, line in enumerate(file.read_text("utf-8").splitlines(), 1) if written.match(line)), "")
