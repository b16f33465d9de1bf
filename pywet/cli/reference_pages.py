"""Pages of the documentation: those of docs/, and the reference pages generated from classes and schemas."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator
from functools import cached_property, reduce
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pywet.errors import PywetError, one_line
from pywet.shipped import NOTEBOOK, place

HEAD = """# Configuration, key by key

Made from the schemas in `workflow/schemas`, with which every file is checked. How the files are used:
[configuration](configuration.md).
"""


def configuration() -> str:
    """Return the page of all keys of `config/`, a table for each group, from their validation schemas."""
    lines = [HEAD]
    for path in sorted((place("workflow") / "schemas").glob("*.schema.json")):
        schema = json.loads(path.read_text())
        name = path.name.removesuffix(".schema.json")
        lines += [f"\n## {name}{'.csv' if name == 'cases' else '.yaml'}\n", *_table(schema)]
        for group, content in sorted(schema.get("$defs", {}).items()):
            if "properties" in content:
                lines += [f"\n### {name}: {group}\n", *_table(content)]
    return "\n".join(lines) + "\n"


def _table(schema: dict[str, Any]) -> Iterator[str]:
    yield schema.get("description", "").replace("\n", " ")
    yield "\n| key | what | default |\n|---|---|---|"
    for key, value in schema["properties"].items():
        message = value.get("description", "").replace("\n", " ").replace("|", "\\|")
        default = "" if "default" not in value else f"`{json.dumps(value['default'])}`"
        yield f"| `{key}` | {_kind(value)}{': ' if message else ''}{message} | {default} |"


def _kind(value: dict[str, Any], limited: bool = True) -> str:
    """Describe the values that a key accepts."""
    if "$ref" in value:
        return str(value["$ref"]).rpartition("/")[2]
    if "enum" in value:
        return " or ".join(f"`{json.dumps(v)}`" for v in value["enum"])
    if "anyOf" in value:
        return " or ".join(dict.fromkeys(_kind(v, limited) for v in value["anyOf"]))
    if value.get("type") == "array":
        return f"list of {_kind(value['items'], limited)}" if "items" in value else "list"
    return " ".join([value.get("type", "any value"), *(_limits(value) if limited else ())])


SCENE = """# A scene, key by key

Made from the classes that check every scene: each key in YAML and each argument in Python, with its meaning, unit, default and
range. A number outside its range needs `unusual: why` next to it.
How scenes are written: [a custom scene](own-scene.md).
"""


def scene() -> str:
    """Return the page of all classes of `pywet` that make up a scene."""
    import pywet

    classes = [c for c in (getattr(pywet, name) for name in pywet.__all__) if hasattr(c, "model_json_schema")]
    lines = [SCENE]
    for one in sorted(classes, key=lambda c: (c.__name__ != "Scene", c.__name__)):
        lines += [f"\n## {one.__name__}\n", *_scene_table(one)]
    return "\n".join(lines) + "\n"


def _scene_table(group: Any) -> Iterator[str]:
    from pywet.schema import unit_of

    schema, usual = group.model_json_schema(), group.RANGED
    yield schema.get("description", "").replace("\n", " ")
    yield "\n| key | what | unit | default | range |\n|---|---|---|---|---|"
    for key, value in schema["properties"].items():
        message = value.get("description", "").replace("\n", " ").replace("|", "\\|")
        default = f"`{json.dumps(value['default'])}`" if "default" in value else "needed"
        limits = str(usual[key]) if key in usual else " ".join(_limits(value))
        kind = f"{_kind(value, limited=False)}{': ' if message else ''}{message}"
        yield f"| `{key}` | {kind} | {unit_of(key)} | {default} | {limits} |"


def _limits(value: dict[str, Any]) -> list[str]:
    """Return the bounds that a schema states for a key."""
    limits = [f"{sign} {value[k]:g}" for k, sign in LIMITS.items() if k in value]
    return limits + [limit for inner in value.get("anyOf", ()) for limit in _limits(inner)]


COLUMNS = """# Columns and codes

Columns of every table of a run, with unit and meaning, from `pywet/schema.py`. `pywet.load(folder)` gives the same with a table:
`attrs["units"]`, `attrs["meanings"]`, `attrs["codes"]`. Columns that end in `_x`, `_y`, `_z` are one row here; of
`results/liquid_by_*` a column's name says what holds the liquid, and its end the unit.
"""


def columns() -> str:
    """Return the page of all documented columns, codes and reservoirs."""
    from pywet.schema import CODES, RESERVOIRS, TABLES, meanings

    lines = [COLUMNS, "\n## Codes\n\n| column | code | meaning |\n|---|---|---|"]
    lines += [f"| `{column}` | {code} | {text} |" for column, rows in CODES.items() for code, text in rows.items()]
    lines += ["\n## Reservoirs\n\n| `reservoir` | what holds the liquid |\n|---|---|"]
    lines += [f"| `{word}` | {text} |" for word, text in RESERVOIRS.items()]
    for table in (t for t in TABLES if meanings(t)):
        lines += [f"\n## {table}\n\n| column | unit | what |\n|---|---|---|"]
        rows = {re.sub("_[xyz]$", "_x, _y, _z", c): reported for c, reported in meanings(table).items()}
        lines += [f"| `{column}` | {unit.replace('-', '–')} | {text} |" for column, (unit, text) in rows.items()]
    return "\n".join(lines) + "\n"


LIMITS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}

MADE = {"configuration_reference": configuration, "columns": columns, "scene_reference": scene}
"""Page -> function that generates its text."""


def write(folder: Path) -> None:
    """Write the generated pages into a folder if they have changed."""
    for name, made in MADE.items():
        page, text = folder / f"{name}.md", made()
        if not page.exists() or page.read_text() != text:
            page.write_text(text)


def page(name: str) -> str:
    """Return the text of a page by its name, with or without `.md` or a section; raises for an unknown page."""
    word = name.partition("#")[0].removeprefix("docs/").removesuffix(".md").removesuffix(".ipynb")
    if word in MADE:
        return MADE[word]()
    if word == Path(NOTEBOOK).stem:
        cells = json.loads((place("docs") / NOTEBOOK).read_text(encoding="utf-8"))["cells"]
        return "\n\n".join("".join(cell["source"]) for cell in cells)
    pages = {path.stem: path for path in sorted(place("docs").glob("*.md")) if path.stem != "index"}
    if word not in pages:
        known = sorted({*pages, *MADE, Path(NOTEBOOK).stem})
        raise PywetError(
            f"there is no page {one_line(name)} in the documentation; expected one of {', '.join(known)}",
            code="cli.no_page",
            given=name,
            expected=tuple(known),
        )
    text = pages[word].read_text(encoding="utf-8")
    return re.sub(
        r"^```\{eval-rst\}\n(.*?)^```\n", lambda found: _named(found[1]), text, flags=re.DOTALL | re.MULTILINE
    )


def _named(block: str) -> str:
    """Return the signatures and first docstring lines of the objects in a block of Sphinx directives."""
    lines = []
    for directive, path in re.findall(r"^\.\. (auto\w+):: ([\w.]+)", block, flags=re.MULTILINE):
        if directive == "automodule":
            module = import_module(path)
            lines.append(f"{path}: {_first_line(module)}")
            continue
        parts = path.split(".")
        depth = next(k for k in range(len(parts) - 1, 0, -1) if _is_module(".".join(parts[:k])))
        found = reduce(getattr, parts[depth:], import_module(".".join(parts[:depth])))
        lines += [f"{path}{_signature(found)}", f"    {_first_line(found)}"]
        if inspect.isclass(found) and f":: {path}\n   :members:" in block:
            documented = {
                n: m for n, m in vars(found).items() if not n.startswith(("_", "model_")) and inspect.getdoc(m)
            }
            methods = {
                n: m
                for n, m in documented.items()
                if inspect.isfunction(m) or isinstance(m, property | cached_property)
            }
            lines += [
                f"    .{n}{_signature(m) if inspect.isfunction(m) else ''}: {_first_line(m)}"
                for n, m in methods.items()
            ]
    return "\n".join(lines) + "\n"


def _is_module(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:  # the part before the last dot is no package
        return False


def _signature(found: Any) -> str:
    """Return the parameters with their defaults, without types; empty for an object without signature."""
    try:
        parameters = inspect.signature(found).parameters.values()
    except (TypeError, ValueError):
        return ""
    bare = [p.replace(annotation=inspect.Parameter.empty) for p in parameters if p.name != "self"]
    return (
        f"({', '.join(str(p).replace(' ', '') if p.default is p.empty else f'{p.name}={p.default!r}' for p in bare)})"
    )


def _first_line(found: Any) -> str:
    return (inspect.getdoc(found) or "").partition("\n")[0]
