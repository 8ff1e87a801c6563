"""Problem files: `.json`, `.npz`, and pairs of `.mtx` or `.csv` with a `.csv`.

Read without pickle and without running anything. What a header, a size line or a line of text announces is checked
before memory is taken; a file can make the reader hold at most `MAX_ORDER`^2 numbers or `MAX_TEXT` characters.
"""

from __future__ import annotations

import json
import re
import struct
import zipfile
import zlib
from array import array
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TextIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from .errors import FileFormatError

#: Largest order read from a file: 20000 x 20000 doubles are 3.2 GB.
MAX_ORDER = 20_000
#: Largest text file, in bytes.
MAX_TEXT = 2_000_000_000
#: Largest `.json`, in bytes: its numbers become Python objects, an order of magnitude longer than their text.
MAX_JSON = 200_000_000
#: Longest line of an `.mtx`, and of a number.
MAX_LINE = 1_000
#: Longest header of an array in an `.npz`, in bytes.
_MAX_HEADER = 10_000

_HEADER = re.compile(
    r"\{'descr': '([<>|=]?[fiub]\d{1,2})', 'fortran_order': (True|False), 'shape': \(([\dL, ]{0,40})\),? *\}\s*"
)

T = TypeVar("T")

_UNREADABLE = (
    OSError,
    ValueError,
    TypeError,  # a type of eleven bytes
    LookupError,
    OverflowError,
    MemoryError,
    RecursionError,
    EOFError,
    RuntimeError,  # an encrypted or unknown kind of zip member
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


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
    A, q = _read(path, float)
    if q is None and q_path is None and path.suffix.lower() == ".mtx" and path.with_suffix(".csv").exists():
        q_path = path.with_suffix(".csv")
    if q_path is not None:
        rows, _ = _read(Path(q_path), float)
        q = np.ravel(np.asarray(rows)) if Path(q_path).suffix.lower() == ".csv" else rows
    return A, q


def read_matrix(path: str | Path, number: Callable[[str], Any]) -> Any:
    """The matrix in a file: as in `read_problem`, a `.json` may hold the rows alone, and text goes through `number`.

    Raises
    ------
    FileFormatError
        As `read_problem`.
    """
    return _read(Path(path), number)[0]


def read_json(path: str | Path) -> Any:
    """Any value in a `.json` file; no key twice, no number that is not finite.

    Raises
    ------
    FileFormatError
        As `read_problem`.
    """
    return _guarded(Path(path), MAX_JSON, _loads)


def _read(path: Path, number: Callable[[str], Any]) -> tuple[Any, Any]:
    readers: dict[str, Callable[[Path, Callable[[str], Any]], tuple[Any, Any]]] = {
        ".json": _json,
        ".npz": _npz,
        ".mtx": _mtx,
        ".csv": _csv,
    }
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise FileFormatError(f"{path.name}: unknown kind of file; expected one of {', '.join(readers)}")
    limit = MAX_JSON if reader is _json else None if reader is _npz else MAX_TEXT
    return _guarded(path, limit, lambda path: reader(path, number))


def _guarded(path: Path, limit: int | None, read: Callable[[Path], T]) -> T:
    """What `read` returns; whatever it may stumble over in the file becomes one exception."""
    try:
        if path.exists() and not path.is_file():
            raise FileFormatError(f"{path.name}: not a regular file")
        if limit is not None and path.stat().st_size > limit:
            raise FileFormatError(f"{path.name}: larger than {limit} bytes")
        return read(path)
    except FileFormatError:
        raise
    except _UNREADABLE as error:
        raise FileFormatError(f"{path.name}: {error or type(error).__name__}") from error


def _json(path: Path, number: Callable[[str], Any]) -> tuple[Any, Any]:
    data = _loads(path)
    if isinstance(data, list) and number is not float:
        return data, None
    if not isinstance(data, dict) or "A" not in data:
        raise FileFormatError(f'{path.name}: expected an object with keys "A" and "q"')
    return data["A"], data.get("q")


def _loads(path: Path) -> Any:
    def members(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) != len(pairs):
            raise FileFormatError(f"{path.name}: a key stands twice in an object")
        return found

    def constant(name: str) -> float:
        raise FileFormatError(f"{path.name}: {name} is not a finite number")

    return json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=members, parse_constant=constant)


def _npz(path: Path, number: Callable[[str], Any]) -> tuple[Any, Any]:
    with zipfile.ZipFile(path) as archive:
        names = [info.filename.removesuffix(".npy") for info in archive.infolist()]
        if "A" not in names:
            raise FileFormatError(f"{path.name}: no array A")
        if names.count("A") > 1 or names.count("q") > 1:
            raise FileFormatError(f"{path.name}: an array stands twice in the archive")
        return _array(path, archive, "A", 2), _array(path, archive, "q", 1) if "q" in names else None


def _array(path: Path, archive: zipfile.ZipFile, name: str, dimensions: int) -> NDArray[Any]:
    """One member, whose size must be what its header announces, and that an order in reach."""
    size = archive.getinfo(f"{name}.npy").file_size
    with archive.open(f"{name}.npy") as member:
        shape, fortran, dtype = _header(path, name, member)
        if len(shape) != dimensions or any(length > MAX_ORDER for length in shape):
            raise FileFormatError(
                f"{path.name}: {name} has shape {shape}; an order of at most {MAX_ORDER} was expected"
            )
        count = int(np.prod(shape, dtype=np.int64))
        if size != member.tell() + count * dtype.itemsize:
            raise FileFormatError(f"{path.name}: {name} has {size} bytes, its header announces another number")
        data = member.read(count * dtype.itemsize)
    if len(data) != count * dtype.itemsize:
        raise FileFormatError(f"{path.name}: {name} ends early")
    return np.frombuffer(data, dtype=dtype).reshape(shape, order="F" if fortran else "C")


def _header(path: Path, name: str, member: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """The `.npy` header by a pattern: nothing in it is evaluated. Shape, whether columns come first, type."""
    start = member.read(8)
    width = 2 if start[6:7] == b"\x01" else 4
    length = int.from_bytes(member.read(width), "little")
    if start[:6] != b"\x93NUMPY" or length > _MAX_HEADER:
        raise FileFormatError(f"{path.name}: {name} is no array, or its header is longer than {_MAX_HEADER} bytes")
    found = _HEADER.fullmatch(member.read(length).decode("latin-1"))
    if found is None:
        raise FileFormatError(f"{path.name}: {name} does not announce a shape and a real type")
    descr, order, shape = found.groups()
    return tuple(int(x.rstrip("L")) for x in shape.replace(",", " ").split()), order == "True", np.dtype(descr)


def _csv(path: Path, number: Callable[[str], Any]) -> tuple[Any, Any]:
    rows: list[Any] = []
    with path.open(encoding="utf-8") as file:
        for line in _lines(path, file, MAX_LINE * MAX_ORDER):
            if len(rows) == MAX_ORDER:
                raise FileFormatError(f"{path.name}: more than {MAX_ORDER} rows")
            row = map(number, line.replace(",", " ").replace(";", " ").split())
            rows.append(array("d", row) if number is float else list(row))
            if len(rows[-1]) != len(rows[0]) or len(rows[-1]) > MAX_ORDER:
                raise FileFormatError(f"{path.name}: rows of different lengths, or longer than {MAX_ORDER}")
    if number is not float:
        return rows, None
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(rows[0]) if rows else 0), None


def _lines(path: Path, file: TextIO, longest: int) -> Iterator[str]:
    """The lines that are not blank, each read only up to a length that makes sense."""
    while line := file.readline(longest + 1):
        if len(line) > longest:
            raise FileFormatError(f"{path.name}: a line is longer than {longest} characters")
        if line.strip():
            yield line


def _mtx(path: Path, number: Callable[[str], Any]) -> tuple[Any, Any]:
    """Matrix Market: coordinate or array; real or integer; general, symmetric or skew-symmetric. [BPR96]."""
    with path.open(encoding="utf-8") as file:
        header = file.readline(MAX_LINE).lower().split()
        if len(header) != 5 or header[:2] != ["%%matrixmarket", "matrix"]:
            raise FileFormatError(f"{path.name}: not a Matrix Market file")
        layout, field, symmetry = header[2:]
        if layout not in ("coordinate", "array") or field not in ("real", "integer", "double"):
            raise FileFormatError(f"{path.name}: {layout} {field} matrices are not read")
        if symmetry not in ("general", "symmetric", "skew-symmetric"):
            raise FileFormatError(f"{path.name}: {symmetry} matrices are not read")
        body = (line.split() for line in _lines(path, file, MAX_LINE) if not line.startswith("%"))
        sizes = [int(x) for x in next(body, [])]
        if len(sizes) != (3 if layout == "coordinate" else 2):
            raise FileFormatError(f"{path.name}: bad size line")
        rows, columns = sizes[:2]
        if not 0 <= rows <= MAX_ORDER or not 0 <= columns <= MAX_ORDER:
            raise FileFormatError(f"{path.name}: {rows} x {columns} is not between 0 and order {MAX_ORDER}")
        if symmetry != "general" and rows != columns:
            raise FileFormatError(f"{path.name}: {symmetry}, but {rows} x {columns}")
        if layout == "coordinate":
            if not 0 <= sizes[2] <= rows * columns:
                raise FileFormatError(f"{path.name}: {sizes[2]} entries in {rows} x {columns}")
            entries = _coordinates(path, rows, columns, sizes[2], body, number)
        else:
            entries = _column_by_column(path, rows, columns, symmetry, (x for line in body for x in line), number)
        return _assemble(path, rows, columns, symmetry, entries, number), None


def _assemble(
    path: Path,
    rows: int,
    columns: int,
    symmetry: str,
    entries: Iterator[tuple[int, int, Any]],
    number: Callable[[str], Any],
) -> Any:
    A: NDArray[Any] = np.zeros((rows, columns))
    if number is not float:
        A = A.astype(object)
        A[...] = 0
    seen = np.zeros((rows, columns), dtype=bool)
    sign = {"symmetric": 1, "skew-symmetric": -1}.get(symmetry)
    for i, j, x in entries:
        if seen[i, j]:
            raise FileFormatError(f"{path.name}: entry ({i + 1}, {j + 1}) is given twice")
        if sign == -1 and i == j and x != 0:
            raise FileFormatError(f"{path.name}: skew-symmetric, but entry ({i + 1}, {j + 1}) is {x}")
        A[i, j], seen[i, j] = x, True
        if sign is not None and i != j:
            A[j, i], seen[j, i] = sign * x, True
    return A if number is float else A.tolist()


def _coordinates(
    path: Path, rows: int, columns: int, announced: int, body: Iterator[list[str]], number: Callable[[str], Any]
) -> Iterator[tuple[int, int, Any]]:
    count = 0
    for words in body:
        row, column, value = words
        i, j = int(row) - 1, int(column) - 1
        if not (0 <= i < rows and 0 <= j < columns):
            raise FileFormatError(f"{path.name}: entry ({i + 1}, {j + 1}) is outside {rows} x {columns}")
        count += 1
        if count > announced:
            break
        yield i, j, number(value)
    if count != announced:
        raise FileFormatError(
            f"{path.name}: {announced} entries announced, {'more' if count > announced else count} found"
        )


def _column_by_column(
    path: Path, rows: int, columns: int, symmetry: str, values: Iterator[str], number: Callable[[str], Any]
) -> Iterator[tuple[int, int, Any]]:
    for j in range(columns):
        first = {"general": 0, "symmetric": j, "skew-symmetric": j + 1}[symmetry]
        for i in range(first, rows):
            value = next(values, None)
            if value is None:
                raise FileFormatError(f"{path.name}: fewer entries than the size line announces")
            yield i, j, number(value)
    if next(values, None) is not None:
        raise FileFormatError(f"{path.name}: more entries than the size line announces")
