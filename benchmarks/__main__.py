"""`python -m benchmarks [PART ...]`: run benchmarks, print their figures, keep them in `benchmarks/results.json`."""

import importlib
import json
import pkgutil
import sys
from pathlib import Path
from typing import Any

import benchmarks


def run_parts(names: list[str]) -> dict[str, Any]:
    known = sorted(module.name for module in pkgutil.iter_modules(benchmarks.__path__) if module.name != "__main__")
    for name in names:
        if name not in known:
            sys.exit(f"There is no benchmark {name!r}. Known: {', '.join(known)}.")
    results = {}
    for name in names or known:
        print(f"{name} …", flush=True)
        results[name] = importlib.import_module(f"benchmarks.{name}").main()
        print(json.dumps(results[name], indent=2), flush=True)
    return results


if __name__ == "__main__":
    figures = run_parts(sys.argv[1:])
    Path(benchmarks.__path__[0], "results.json").write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
