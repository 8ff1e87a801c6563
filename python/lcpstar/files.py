"""Problem files: `.json`, `.npz`, and pairs of `.mtx` or `.csv` with a `.csv`.

Read without pickle and without running anything; sizes are checked before memory is taken.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import FileFormatError

#: Largest order read from a file: 20000 x 20000 doubles are 3.2 GB.
MAX_ORDER = 20_000
#: Largest text file, in bytes.
MAX_TEXT = 2_000_000_000


def read_problem(path: str | Path, q_path: str | Path | None = None) -> tuple[Any, Any]:
    """Read `(A, q)` from a file; `q` is `None` when the file holds a matrix alone.

    `.json`: an object with keys "A" (rows) and "q". `.npz`: arrays A and q. `.mtx` (Matrix Market) or `.csv`: the
    matrix, with q in `q_path`, or in the `.csv` of the same stem for an `.mtx`.

    Raises
    ------
    FileFormatError
        The file is missing, malformed, incomplete or too large; one line says what.
    """
    path = Path(path)
    readers: dict[str, Callable[[Path], tuple[Any, Any]]] = {".json": _json, ".npz": _npz, ".mtx": _mtx, ".csv": _csv}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise FileFormatError(f"{path.name}: unknown kind of file; expected one of {', '.join(readers)}")
    try:
        if path.suffix.lower() != ".npz" and path.stat().st_size > MAX_TEXT:
            raise FileFormatError(f"{path.name}: larger than {MAX_TEXT} bytes")
        A, q = reader(path)
        if q is None and q_path is None and path.suffix.lower() == ".mtx" and path.with_suffix(".csv").exists():
            q_path = path.with_suffix(".csv")
        if q_path is not None:
            q = np.ravel(_table(Path(q_path)))
    except FileFormatError:
        raise
    except (OSError, UnicodeDecodeError, ValueError, KeyError, IndexError, zipfile.BadZipFile, RecursionError) as error:
        raise FileFormatError(f"{path.name}: {_one_line(error)}") from error
    return A, q


def _json(path: Path) -> tuple[Any, Any]:
    data = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(data, dict) or "A" not in data:
        raise FileFormatError(f'{path.name}: expected an object with keys "A" and "q"')
    return data["A"], data.get("q")


def _npz(path: Path) -> tuple[Any, Any]:
    with zipfile.ZipFile(path) as archive:
        names = {name.removesuffix(".npy") for name in archive.namelist()}
        if "A" not in names:
            raise FileFormatError(f"{path.name}: no array A")
        for name in ("A", "q"):
            if name in names:
                with archive.open(f"{name}.npy") as member:
                    _check_header(path, name, member)
    with np.load(path, allow_pickle=False) as data:
        return data["A"], data["q"] if "q" in names else None


def _check_header(path: Path, name: str, member: Any) -> None:
    version = np.lib.format.read_magic(member)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(member)
    if dtype.hasobject:
        raise FileFormatError(f"{path.name}: {name} holds Python objects")
    if any(length > MAX_ORDER for length in shape) or len(shape) > 2:
        raise FileFormatError(f"{path.name}: {name} has shape {shape}; a matrix of order <= {MAX_ORDER} was expected")


def _csv(path: Path) -> tuple[Any, Any]:
    return _table(path), None


def _table(path: Path) -> NDArray[np.float64]:
    text = path.read_text(encoding="utf-8").strip()
    rows = [[float(x) for x in line.replace(",", " ").replace(";", " ").split()] for line in text.splitlines()]
    if len({len(row) for row in rows}) > 1:
        raise FileFormatError(f"{path.name}: rows of different lengths")
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1)


def _mtx(path: Path) -> tuple[Any, Any]:
    """Matrix Market: coordinate or array; real or integer; general, symmetric or skew-symmetric. [BPR96]."""
    with path.open(encoding="utf-8") as lines:
        header = next(lines, "").lower().split()
        if len(header) != 5 or header[:2] != ["%%matrixmarket", "matrix"]:
            raise FileFormatError(f"{path.name}: not a Matrix Market file")
        layout, field, symmetry = header[2:]
        if layout not in ("coordinate", "array") or field not in ("real", "integer", "double"):
            raise FileFormatError(f"{path.name}: {layout} {field} matrices are not read")
        if symmetry not in ("general", "symmetric", "skew-symmetric"):
            raise FileFormatError(f"{path.name}: {symmetry} matrices are not read")
        body = (line.split() for line in lines if line.strip() and not line.startswith("%"))
        sizes = [int(x) for x in next(body, [])]
        if len(sizes) != (3 if layout == "coordinate" else 2):
            raise FileFormatError(f"{path.name}: bad size line")
        rows, columns = sizes[:2]
        if not 0 <= rows <= MAX_ORDER or not 0 <= columns <= MAX_ORDER:
            raise FileFormatError(f"{path.name}: {rows} x {columns} is larger than order {MAX_ORDER}")
        entries = (
            ((int(i) - 1, int(j) - 1, float(x)) for i, j, x in body)
            if layout == "coordinate"
            else _array_entries(rows, columns, symmetry, (float(x) for line in body for x in line))
        )
        A = np.zeros((rows, columns))
        sign = {"symmetric": 1.0, "skew-symmetric": -1.0}.get(symmetry)
        count = 0
        for i, j, x in entries:
            if not (0 <= i < rows and 0 <= j < columns):
                raise FileFormatError(f"{path.name}: entry ({i + 1}, {j + 1}) is outside {rows} x {columns}")
            A[i, j] = x
            count += 1
            if sign is not None and i != j:
                A[j, i] = sign * x
    if layout == "coordinate" and count != sizes[2]:
        raise FileFormatError(f"{path.name}: {sizes[2]} entries announced, {count} found")
    return A, None


def _array_entries(rows: int, columns: int, symmetry: str, values: Any) -> Any:
    for j in range(columns):
        first = {"general": 0, "symmetric": j, "skew-symmetric": j + 1}[symmetry]
        for i in range(first, rows):
            value = next(values, None)
            if value is None:
                raise FileFormatError("fewer entries than the size line announces")
            yield i, j, value


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
