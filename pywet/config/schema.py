"""JSON schemas of the configuration files, generated from the types; the workflow validates with them.

`python -m pywet.config.schema workflow/schemas` rewrites them; a test fails if they are out of date.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pywet.config.loading import FILES
from pywet.errors import border
from pywet.util.files import write_json


def schemas() -> dict[str, dict[str, Any]]:
    """File name of the schema -> schema."""
    found = {}
    for file, model in FILES.items():
        schema = model.model_json_schema()
        found[f"{Path(file).stem}.schema.json"] = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
    return found


if __name__ == "__main__":
    with border():
        for name, schema in schemas().items():
            path = Path(sys.argv[1] if len(sys.argv) > 1 else "workflow/schemas") / name
            write_json(path, schema)
            print(path)
