"""All benchmarks that leave a record in `benches/record/`: `make bench`."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

#: In the order of the README.
BENCHMARKS = ["call", "families", "batch", "interior_point", "classes", "scenes"]


def main() -> None:
    folder = Path(__file__).parent
    sys.path.insert(0, str(folder))
    for name in BENCHMARKS:
        sys.argv = [f"{name}.py"]
        runpy.run_path(str(folder / f"{name}.py"), run_name="__main__")


if __name__ == "__main__":
    main()
