"""Writes the configuration reference from the schemas that the program itself checks with: a table for each group of keys."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SCHEMAS = Path(__file__).parent.parent / "workflow" / "schemas"
HEAD = """# Configuration, key by key

Made from the schemas in `workflow/schemas`, with which every file is checked. How the files are used:
[configuration](configuration.md).
"""


def write(page: Path) -> None:
    """The page, from all schemas there are."""
    lines = [HEAD]
    for path in sorted(SCHEMAS.glob("*.schema.json")):
        schema = json.loads(path.read_text())
        name = path.name.removesuffix(".schema.json")
        lines += [f"\n## {name}{'.csv' if name == 'cases' else '.yaml'}\n", *_table(schema)]
        for group, content in sorted(schema.get("$defs", {}).items()):
            if "properties" in content:
                lines += [f"\n### {name}: {group}\n", *_table(content)]
    text = "\n".join(lines) + "\n"
    if not page.exists() or page.read_text() != text:
        page.write_text(text)


def _table(schema: dict[str, Any]) -> Iterator[str]:
    yield schema.get("description", "").replace("\n", " ")
    yield "\n| key | what | default |\n|---|---|---|"
    for key, value in schema["properties"].items():
        said = value.get("description", "").replace("\n", " ").replace("|", "\\|")
        default = "" if "default" not in value else f"`{json.dumps(value['default'])}`"
        yield f"| `{key}` | {_kind(value)}{': ' if said else ''}{said} | {default} |"


def _kind(value: dict[str, Any]) -> str:
    """What may stand at a key, in a few words."""
    if "$ref" in value:
        return str(value["$ref"]).rpartition("/")[2]
    if "enum" in value:
        return " or ".join(f"`{json.dumps(v)}`" for v in value["enum"])
    if "anyOf" in value:
        return " or ".join(dict.fromkeys(_kind(v) for v in value["anyOf"]))
    if value.get("type") == "array":
        return f"list of {_kind(value['items'])}" if "items" in value else "list"
    limits = [f"{sign} {value[k]:g}" for k, sign in LIMITS.items() if k in value]
    return " ".join([value.get("type", "any value"), *limits])


LIMITS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
