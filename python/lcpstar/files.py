"""Problem files: `.json`, `.npz`, and pairs of `.mtx` or `.csv` with a `.csv`.

Read without pickle and without running anything. What a header, a size line or a line of text announces is checked
before memory is taken; a file can make the reader hold at most `MAX_ORDER`^2 numbers or `MAX_TEXT` characters.
"""

from __future__ import annotations

import importlib
import itertools
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

from .errors import FileFormatError, MissingPackageError
from .sparse import check_arrays, is_sparse

#: Largest order read into a dense matrix: 20000 x 20000 doubles are 3.2 GB.
MAX_ORDER = 20_000
#: Largest order of a sparse matrix.
MAX_SPARSE_ORDER = 100_000_000
#: A matrix in a sparse file becomes dense up to this order, where every method takes it; beyond, it stays sparse.
DENSE_UP_TO = 500
#: Largest order of a matrix whose entries are read as exact numbers: what exponential tests could ever decide.
MAX_EXACT_ORDER = 1_000
#: Above this order a coordinate file must hold an entry a row at least: no small file claims gigabytes.
MAX_EMPTY_ORDER = 1_000
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

#: A number in text: a decimal one or a fraction; what else it may be is up to its reader. An integer.
_NUMBER = re.compile(r"[-+./0-9A-Za-z]+", re.ASCII)
_INTEGER = re.compile(r"[-+]?[0-9]+", re.ASCII)

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

    `.json`: an object with keys "A" (rows) and "q". `.npz`: arrays A and q, or what `scipy.sparse.save_npz` writes.
    `.mtx` (Matrix Market) or `.csv`: the matrix, with q in `q_path`, or in the `.csv` of the same stem for an `.mtx`.
    A is an array; a `scipy.sparse` one if the file holds it sparse and its order is above `DENSE_UP_TO`.

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
        q = _read(Path(q_path), float)[0]
        if is_sparse(q) or np.ndim(q) != 2 or 1 not in np.shape(q):
            raise FileFormatError(f"{Path(q_path).name}: q must be one row or one column, got shape {np.shape(q)}")
        q = np.ravel(q)
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
    for key in ("A", "q"):
        if _holds_boolean(data.get(key)):
            raise FileFormatError(f"{path.name}: {key} must hold numbers, got true or false")
    return data["A"], data.get("q")


def _holds_boolean(value: Any) -> bool:
    return any(map(_holds_boolean, value)) if isinstance(value, list) else isinstance(value, bool)


def _loads(path: Path) -> Any:
    def members(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) != len(pairs):
            raise FileFormatError(f"{path.name}: a key stands twice in an object")
        return found

    def constant(name: str) -> float:
        raise FileFormatError(f"{path.name}: {name} is not a finite number")

    return json.loads(path.read_text(encoding="utf-8-sig"), object_pairs_hook=members, parse_constant=constant)


def _npz(path: Path, number: Callable[[str], Any]) -> tuple[Any, Any]:
    with zipfile.ZipFile(path) as archive:
        names = [info.filename.removesuffix(".npy") for info in archive.infolist()]
        if len(set(names)) != len(names):
            raise FileFormatError(f"{path.name}: an array stands twice in the archive")
        if "A" not in names and "format" in names:
            return _saved_sparse(path, archive, number), None
        if "A" not in names:
            raise FileFormatError(f"{path.name}: no array A")
        return _array(path, archive, "A", 2), _array(path, archive, "q", 1) if "q" in names else None


#: The arrays of the formats that `scipy.sparse.save_npz` writes, in the order of scipy's constructors, with the
#: dimensions of the first.
_FORMATS = {
    "csr": (("data", "indices", "indptr"), 1),
    "csc": (("data", "indices", "indptr"), 1),
    "bsr": (("data", "indices", "indptr"), 3),
    "coo": (("data", "row", "col"), 1),
    "dia": (("data", "offsets"), 2),
}


def _saved_sparse(path: Path, archive: zipfile.ZipFile, number: Callable[[str], Any]) -> Any:
    """What `scipy.sparse.save_npz` wrote, checked as any other sparse matrix before scipy works with it."""
    if archive.getinfo("format.npy").file_size > _MAX_HEADER:
        raise FileFormatError(f"{path.name}: format is longer than {_MAX_HEADER} bytes")
    kind = archive.read("format.npy").decode("latin-1").replace("\0", "")[-3:]
    if kind not in _FORMATS:
        raise FileFormatError(f"{path.name}: sparse format {kind!r} is not one of {', '.join(_FORMATS)}")
    shape = tuple(int(x) for x in _array(path, archive, "shape", 1))
    names, dimensions = _FORMATS[kind]
    longest = MAX_ORDER**2
    data, *indices = (_array(path, archive, name, dimensions if name == "data" else 1, longest) for name in names)
    if len(shape) != 2 or shape[0] != shape[1]:
        raise FileFormatError(f"{path.name}: a square matrix was expected, got shape {shape}")
    _check_order(path, shape[0], shape[1], data.size, number, sparse=True)
    arrays = (data, *indices) if kind in ("csr", "csc", "bsr") else (data, indices[0] if kind == "dia" else (*indices,))
    A = getattr(_scipy_sparse(path), f"{kind}_array")(arrays, shape=shape)
    check_arrays(A, shape[0])
    return A.toarray() if shape[0] <= DENSE_UP_TO or number is not float else A


def _scipy_sparse(path: Path) -> Any:
    try:
        return importlib.import_module("scipy.sparse")
    except ImportError as error:
        raise MissingPackageError(f"{path.name}: sparse matrices need scipy: pip install scipy") from error


def _check_order(path: Path, rows: int, columns: int, entries: int, number: Callable[[str], Any], sparse: bool) -> None:
    """An order in reach, and no small file that claims a large one."""
    largest = MAX_EXACT_ORDER if number is not float else MAX_SPARSE_ORDER if sparse else MAX_ORDER
    if not 0 <= rows <= largest or not 0 <= columns <= largest:
        raise FileFormatError(f"{path.name}: {rows} x {columns} is not between 0 and order {largest}")
    if sparse and max(rows, columns) > max(MAX_EMPTY_ORDER, entries):
        raise FileFormatError(f"{path.name}: too few entries for {rows} x {columns}")


def _array(path: Path, archive: zipfile.ZipFile, name: str, dimensions: int, longest: int = MAX_ORDER) -> NDArray[Any]:
    """One member, whose size must be what its header announces, and that an order in reach."""
    size = archive.getinfo(f"{name}.npy").file_size
    with archive.open(f"{name}.npy") as member:
        shape, fortran, dtype = _header(path, name, member)
        if len(shape) != dimensions or any(length > longest for length in shape):
            raise FileFormatError(f"{path.name}: {name} has shape {shape}; an order of at most {longest} was expected")
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
    with path.open(encoding="utf-8-sig") as file:
        for place, line in _lines(path, file, MAX_LINE * MAX_ORDER):
            if place != len(rows) + 1:
                raise FileFormatError(f"{path.name}: line {len(rows) + 1}, column 1: blank")
            if len(rows) == MAX_ORDER:
                raise FileFormatError(f"{path.name}: more than {MAX_ORDER} rows")
            row = [_value(path, place, j, cell, number) for j, cell in enumerate(_cells(path, place, line), 1)]
            rows.append(array("d", row) if number is float else row)
            if len(row) != len(rows[0]) or len(row) > MAX_ORDER:
                raise FileFormatError(
                    f"{path.name}: line {place} has {len(row)} numbers, line 1 has {len(rows[0])}, {MAX_ORDER} are read"
                )
    if not rows:
        raise FileFormatError(f"{path.name}: no numbers")
    return rows if number is not float else np.array(rows, dtype=np.float64), None


def _cells(path: Path, place: int, line: str) -> list[str]:
    """What stands between commas, semicolons or tabs, or, in a line without them, between blanks."""
    if "," in line and ";" in line:
        raise FileFormatError(f"{path.name}: line {place} has both ',' and ';': which one separates?")
    separator = next((c for c in ",;\t" if c in line), None)
    return [cell.strip() for cell in line.split(separator)]


def _value(path: Path, line: int, column: int, text: str, number: Callable[[str], Any]) -> Any:
    """One number, or an exception that says where it was expected."""
    place = f"{path.name}: line {line}, column {column}"
    if not text:
        raise FileFormatError(f"{place}: blank")
    shown = repr(text if len(text) <= 40 else text[:40] + "...")
    try:
        if not _NUMBER.fullmatch(text):  # Python takes digits of other scripts, and 1_0 for 10
            raise ValueError
        value = number(text)
    except (ValueError, TypeError, ArithmeticError):
        raise FileFormatError(f"{place}: {shown} is no number") from None
    if number is float and abs(value) >= 2.0**53 and _INTEGER.fullmatch(text) and int(text) != value:
        raise FileFormatError(f"{place}: {shown} is no double")
    return value


def _lines(path: Path, file: TextIO, longest: int) -> Iterator[tuple[int, str]]:
    """The lines that are not blank with their numbers, each read only up to a length that makes sense."""
    for place in itertools.count(1):
        line = file.readline(longest + 1)
        if len(line) > longest:
            raise FileFormatError(f"{path.name}: line {place} is longer than {longest} characters")
        if not line:
            return
        if line.strip():
            yield place, line


Words = Iterator[tuple[int, list[str]]]


def _mtx(path: Path, number: Callable[[str], Any]) -> tuple[Any, Any]:
    """Matrix Market: coordinate or array; real or integer; general, symmetric or skew-symmetric. [BPR96]."""
    with path.open(encoding="utf-8-sig") as file:
        lines = _lines(path, file, MAX_LINE)
        header = next(lines, (1, ""))[1].lower().split()
        if len(header) != 5 or header[:2] != ["%%matrixmarket", "matrix"]:
            raise FileFormatError(f"{path.name}: not a Matrix Market file")
        layout, field, symmetry = header[2:]
        if layout not in ("coordinate", "array") or field not in ("real", "integer", "double"):
            raise FileFormatError(f"{path.name}: {layout} {field} matrices are not read")
        if symmetry not in ("general", "symmetric", "skew-symmetric"):
            raise FileFormatError(f"{path.name}: {symmetry} matrices are not read")
        body = ((place, line.split()) for place, line in lines if not line.startswith("%"))
        place, words = next(body, (1, []))
        if len(words) != (3 if layout == "coordinate" else 2):
            raise FileFormatError(f"{path.name}: line {place}: bad size line")
        rows, columns, *announced = (_whole(path, place, word) for word in words)
        _check_order(path, rows, columns, announced[0] if announced else 0, number, sparse=layout == "coordinate")
        if symmetry != "general" and rows != columns:
            raise FileFormatError(f"{path.name}: {symmetry}, but {rows} x {columns}")
        if layout == "coordinate":
            if not 0 <= announced[0] <= rows * columns:
                raise FileFormatError(f"{path.name}: {announced[0]} entries in {rows} x {columns}")
            if announced[0] > path.stat().st_size:
                raise FileFormatError(f"{path.name}: too few entries for {rows} x {columns}")
            entries = _coordinates(path, rows, columns, announced[0], body, number)
        else:
            if rows * (columns - 1) > path.stat().st_size:  # an entry takes two characters; symmetric files hold half
                raise FileFormatError(f"{path.name}: fewer entries than the size line announces")
            entries = _column_by_column(path, rows, columns, symmetry, body, number)
        return _assemble(path, rows, columns, symmetry, entries, number, sparse=layout == "coordinate"), None


def _whole(path: Path, place: int, text: str) -> int:
    if not _INTEGER.fullmatch(text) or len(text) > 18:
        raise FileFormatError(f"{path.name}: line {place}: {text[:40]!r} is no index or size")
    return int(text)


def _assemble(
    path: Path,
    rows: int,
    columns: int,
    symmetry: str,
    entries: Iterator[tuple[int, int, Any]],
    number: Callable[[str], Any],
    sparse: bool,
) -> Any:
    places: tuple[array[int], array[int]] = (array("q"), array("q"))
    given: Any = array("d") if number is float else []
    for *place, x in entries:
        for indices, index in zip(places, place, strict=True):
            indices.append(index)
        given.append(x)
    i, j = (np.array(indices, dtype=np.int64) for indices in places)
    values: NDArray[Any] = np.array(given, dtype=np.float64 if number is float else object)
    if symmetry != "general":
        for k in np.flatnonzero((i == j) & (values != 0)) if symmetry == "skew-symmetric" else ():
            raise FileFormatError(f"{path.name}: skew-symmetric, but entry ({i[k] + 1}, {i[k] + 1}) is {values[k]}")
        off = i != j
        mirrored = values[off] if symmetry == "symmetric" else -values[off]
        i, j, values = np.append(i, j[off]), np.append(j, i[off]), np.append(values, mirrored)
    keys = np.sort(i * columns + j)
    for key in keys[1:][keys[1:] == keys[:-1]]:
        raise FileFormatError(f"{path.name}: entry ({key // columns + 1}, {key % columns + 1}) is given twice")
    large = max(rows, columns)
    if sparse and number is float and large > DENSE_UP_TO:
        try:
            return _scipy_sparse(path).csr_array((values, (i, j)), shape=(rows, columns))
        except MissingPackageError:
            if large > MAX_ORDER:
                raise
    A: NDArray[Any] = np.zeros((rows, columns), dtype=values.dtype)
    A[i, j] = values
    return A if number is float else A.tolist()


def _coordinates(
    path: Path, rows: int, columns: int, announced: int, body: Words, number: Callable[[str], Any]
) -> Iterator[tuple[int, int, Any]]:
    count = 0
    for place, words in body:
        if len(words) != 3:
            raise FileFormatError(f"{path.name}: line {place}: a row, a column and a number were expected")
        i, j = _whole(path, place, words[0]) - 1, _whole(path, place, words[1]) - 1
        if not (0 <= i < rows and 0 <= j < columns):
            raise FileFormatError(f"{path.name}: line {place}: entry ({i + 1}, {j + 1}) is outside {rows} x {columns}")
        count += 1
        if count > announced:
            break
        yield i, j, _value(path, place, 3, words[2], number)
    if count != announced:
        raise FileFormatError(
            f"{path.name}: {announced} entries announced, {'more' if count > announced else count} found"
        )


def _column_by_column(
    path: Path, rows: int, columns: int, symmetry: str, body: Words, number: Callable[[str], Any]
) -> Iterator[tuple[int, int, Any]]:
    texts = ((place, k, word) for place, words in body for k, word in enumerate(words, 1))
    for j in range(columns):
        first = {"general": 0, "symmetric": j, "skew-symmetric": j + 1}[symmetry]
        for i in range(first, rows):
            place = next(texts, None)
            if place is None:
                raise FileFormatError(f"{path.name}: fewer entries than the size line announces")
            yield i, j, _value(path, *place, number)
    if next(texts, None) is not None:
        raise FileFormatError(f"{path.name}: more entries than the size line announces")
