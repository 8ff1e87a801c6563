"""Hostile files: exit status 2, one line on stderr, no memory taken for what a header merely announces."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import resource
import struct
import tracemalloc
import zipfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lcpstar import errors, solve
from lcpstar.__main__ import main
from lcpstar.files import MAX_ORDER, read_matrix, read_problem

EYE = np.eye(2)
Q = np.array([-1.0, 1.0])


def npy(array=None, header=None, version=(1, 0), magic=b"\x93NUMPY", data=None, padding=0):
    """A `.npy` member, possibly a lie."""
    out = io.BytesIO()
    text = (
        repr(header if header is not None else np.lib.format.header_data_from_array_1_0(array)).encode()
        + b" " * padding
        + b"\n"
    )
    out.write(magic + bytes(version))
    out.write(struct.pack("<H" if version == (1, 0) else "<I", len(text)))
    out.write(text)
    out.write(array.tobytes() if data is None else data)
    return out.getvalue()


def archive(path, members, compression=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", compression) as file:
        for name, content in members:
            file.writestr(name, content)
    return path


def claims(shape, descr="<f8"):
    return {"descr": descr, "fortran_order": False, "shape": shape}


ARCHIVES = {
    "claims 10^12 entries": npy(header=claims((10**6, 10**6)), data=b""),
    "claims 10^18 entries": npy(header=claims((10**9, 10**9)), data=b""),
    "claims more than it holds": npy(header=claims((MAX_ORDER, MAX_ORDER)), data=b"\0" * 64),
    "claims less than it holds": npy(header=claims((2, 2)), data=b"\0" * 64),
    "negative size": npy(header=claims((-2, -2)), data=b"\0" * 32),
    "vector": npy(header=claims((4,)), data=b"\0" * 32),
    "no tuple": npy(header=claims([2, 2]), data=b"\0" * 32),
    "objects": npy(header=claims((2, 2), "|O"), data=b"\0" * 32),
    "long strings": npy(header=claims((2, 2), "<U100000000"), data=b""),
    "void": npy(header=claims((2, 2), "|V8"), data=b"\0" * 32),
    "complex": npy(header=claims((2, 2), "<c16"), data=b"\0" * 64),
    "record": npy(header=claims((2, 2), [("x", "<f8"), ("y", "|O")]), data=b"\0" * 64),
    "long header": npy(header=claims((2, 2)), version=(2, 0), data=b"\0" * 32, padding=10**6),
    "nested header": npy(header=claims((2, 2)), data=b"").replace(b"(2, 2)", b"(" * 3000),
    "code in the header": npy(header=claims((2, 2)), data=b"").replace(b"(2, 2)", b"exit()"),
    "other magic": npy(EYE, magic=b"\x93NUMPX"),
    "other version": npy(EYE, version=(9, 9)),
    "empty member": b"",
    "python 2 header": npy(EYE, data=b"").replace(b"(2, 2)", b"(2L, 2L)"),
}


@pytest.mark.parametrize("content", ARCHIVES.values(), ids=ARCHIVES.keys())
@pytest.mark.parametrize("command", ["solve", "classify"])
def test_hostile_arrays(tmp_path, capfd, content, command):
    path = archive(tmp_path / "p.npz", [("A.npy", content), ("q.npy", npy(Q))])
    one_line(capfd, [command, str(path)])


def test_hostile_archives(tmp_path, capfd):
    good = npy(EYE)
    with pytest.warns(UserWarning, match="Duplicate name"):
        twice = archive(tmp_path / "twice.npz", [("A.npy", good), ("A.npy", good), ("q.npy", npy(Q))])
    whole = archive(tmp_path / "p.npz", [("A.npy", good), ("q.npy", npy(Q))], zipfile.ZIP_DEFLATED).read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    flipped = bytearray(whole)
    flipped[40:60] = b"\xff" * 20
    (tmp_path / "flipped.npz").write_bytes(flipped)
    locked = whole.replace(b"PK\x03\x04\x14\x00\x00\x00", b"PK\x03\x04\x14\x00\x01\x00")
    locked = locked.replace(b"PK\x01\x02\x14\x03\x14\x00\x00\x00", b"PK\x01\x02\x14\x03\x14\x00\x01\x00")
    (tmp_path / "locked.npz").write_bytes(locked)
    other = whole.replace(b"\x14\x00\x00\x00\x08\x00", b"\x14\x00\x00\x00\x63\x00")
    (tmp_path / "method.npz").write_bytes(other)
    for path in [twice, *(tmp_path / f"{name}.npz" for name in ("cut", "flipped", "locked", "method"))]:
        one_line(capfd, ["solve", str(path)])


def test_a_zip_bomb_is_not_unpacked(tmp_path, capfd):
    bomb = archive(tmp_path / "p.npz", [("A.npy", npy(header=claims((2, 2)), data=bytes(10**8)))], zipfile.ZIP_DEFLATED)
    assert bomb.stat().st_size < 200_000
    tracemalloc.start()
    one_line(capfd, ["solve", str(bomb)])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5_000_000


COORDINATE = "%%MatrixMarket matrix coordinate real general\n"
ARRAY = "%%MatrixMarket matrix array real general\n"
TEXTS = {
    "huge.mtx": COORDINATE + "1000000000000 1000000000000 1\n1 1 1\n",
    "empty_giant.mtx": COORDINATE + "20000 20000 1\n1 1 1\n",
    "lying_giant.mtx": COORDINATE + "20000 20000 20000\n1 1 1\n",
    "array_giant.mtx": ARRAY + "20000 20000\n1\n",
    "negative.mtx": COORDINATE + "-2 -2 1\n1 1 1\n",
    "negative_count.mtx": COORDINATE + "2 2 -1\n",
    "too_many.mtx": COORDINATE + "2 2 1\n1 1 1\n2 2 1\n",
    "impossible_count.mtx": COORDINATE + "2 2 1000000000000\n1 1 1\n",
    "too_few.mtx": COORDINATE + "2 2 3\n1 1 1\n2 2 1\n",
    "twice.mtx": COORDINATE + "2 2 2\n1 1 1\n1 1 2\n",
    "both_triangles.mtx": COORDINATE.replace("general", "symmetric") + "2 2 2\n1 2 1\n2 1 2\n",
    "skew_diagonal.mtx": COORDINATE.replace("general", "skew-symmetric") + "2 2 1\n1 1 1\n",
    "not_square.mtx": ARRAY.replace("general", "symmetric") + "2 3\n1\n1\n1\n1\n1\n",
    "array_rest.mtx": ARRAY + "1 1\n1\n2\n",
    "array_short.mtx": ARRAY + "2 2\n1\n2\n",
    "words.mtx": COORDINATE + "2 2 1\n1 1 one\n",
    "columns.mtx": COORDINATE + "2 2 1\n1 1\n",
    "floats.mtx": COORDINATE + "2.5 2 1\n1 1 1\n",
    "nan.mtx": COORDINATE + "1 1 1\n1 1 nan\n",
    "long_line.mtx": COORDINATE + "1 1 1\n" + "1 " * 10_000 + "\n",
    "empty.mtx": "",
    "header_only.mtx": COORDINATE,
    "complex.mtx": COORDINATE.replace("real", "complex") + "1 1 1\n1 1 1 1\n",
    "index_underscore.mtx": COORDINATE + "2 2 1\n1_0 1 1\n",
    "value_underscore.mtx": COORDINATE + "1 1 1\n1 1 1_0\n",
    "ragged.csv": "1,2\n3\n",
    "underscore.csv": "1_0\n",
    "other_digits.csv": "\u0663\n",
    "blank_cell.csv": "1,,2\n1,2,3\n1,2,3\n",
    "trailing_comma.csv": "1,2,\n3,4,\n",
    "two_separators.csv": "1,5;2,5\n1,5;2,5\n",
    "blank_line.csv": "1,2\n\n3,4\n",
    "blank_tab.csv": "1\t\t2\n",
    "empty.csv": "",
    "blank.csv": "\n \n",
    "true.json": '{"A": [[true]], "q": [1]}',
    "false_among_numbers.json": '{"A": [[1.5, false], [0, 1]], "q": [1, 2]}',
    "trailing.json": '{"A": [[1]], "q": [1]} x',
    "words.csv": "a,b\nc,d\n",
    "inf.csv": "inf\n",
    "nul.csv": "1\0,2\n",
    "wide.csv": "1," * (MAX_ORDER + 1) + "\n",
    "nested.json": "[" * 100_000,
    "deep.json": '{"A": ' + "[" * 900 + "1" + "]" * 900 + ', "q": [1]}',
    "nan.json": '{"A": [[NaN]], "q": [1]}',
    "inf.json": '{"A": [[1]], "q": [-Infinity]}',
    "twice.json": '{"A": [[1]], "A": [[2]], "q": [1]}',
    "digits.json": '{"A": [[' + "1" * 5000 + ']], "q": [1]}',
    "exponent.json": '{"A": [["1e999999999"]], "q": [1]}',
    "text.json": '{"A": "text", "q": [1]}',
    "null.json": '{"A": null, "q": null}',
    "object.json": '{"A": {"x": 1}, "q": [1]}',
    "bool.json": "true",
    "ragged.json": '{"A": [[1, 2], [3]], "q": [1, 2]}',
    "ragged_object.json": '{"A": [[1, {}], [3, 4]], "q": [1, 2]}',
    "empty.json": "",
    "latin.json": b'{"A": [["\xff"]]}',
}


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("command", ["solve", "classify"])
def test_hostile_texts(tmp_path, capfd, name, command):
    content = TEXTS[name]
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    q = tmp_path / "q.csv"
    q.write_text("-1\n1\n")
    one_line(capfd, [command, str(path), *([str(q)] if path.suffix != ".json" and command == "solve" else [])])


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("1,2\n3,,4\n", "line 2, column 2: blank"),
        ("1;2\n3; \n", "line 2, column 2: blank"),
        ("1\n\n2\n", "line 2, column 1: blank"),
        ("1,2\n3,1_0\n", "line 2, column 2: '1_0' is no number"),
        ("1 2\n3 x\n", "line 2, column 2: 'x' is no number"),
        ("1\n9007199254740993\n", "line 2, column 1: '9007199254740993' is no double"),
        ("1,2\n3\n", "line 2 has 1 numbers, line 1 has 2"),
        ("1,2;3\n", "line 1 has both ',' and ';'"),
    ],
)
def test_a_csv_error_names_line_and_column(tmp_path, text, place):
    (tmp_path / "p.csv").write_text(text)
    with pytest.raises(errors.FileFormatError, match=re.escape(f"p.csv: {place}")):
        read_problem(tmp_path / "p.csv")


def test_a_vector_is_one_row_or_one_column(tmp_path):
    (tmp_path / "A.csv").write_text("1,0,0,0\n0,1,0,0\n0,0,1,0\n0,0,0,1\n")
    for text in ("1,2,3,4\n", "1\n2\n3\n4\n\n", "\ufeff1 2 3 4"):
        (tmp_path / "q.csv").write_text(text, encoding="utf-8")
        assert read_problem(tmp_path / "A.csv", tmp_path / "q.csv")[1].tolist() == [1, 2, 3, 4]
    (tmp_path / "q.csv").write_text("1,2\n3,4\n")
    with pytest.raises(errors.FileFormatError, match=r"q must be one row or one column, got shape \(2, 2\)"):
        read_problem(tmp_path / "A.csv", tmp_path / "q.csv")
    (tmp_path / "q.mtx").write_text(ARRAY + "4 1\n1\n2\n3\n4\n")
    assert read_problem(tmp_path / "A.csv", tmp_path / "q.mtx")[1].tolist() == [1, 2, 3, 4]


def chain(n):
    """Second differences: positive definite, three entries a row."""
    return sp.diags_array([-np.ones(n - 1), np.full(n, 2.01), -np.ones(n - 1)], offsets=[-1, 0, 1])


@pytest.mark.parametrize("kind", ["mtx", "csr", "csc", "coo", "bsr", "dia"])
@pytest.mark.parametrize("n", [4, 10_000])
def test_sparse_files_stay_sparse_where_they_are_large(tmp_path, kind, n):
    path = tmp_path / ("A.mtx" if kind == "mtx" else "A.npz")
    if kind == "mtx":
        i, j = (k + 1 for k in chain(n).tocoo().coords)
        values = chain(n).tocoo().data
        lines = [f"{a} {b} {x}\n" for a, b, x in zip(i, j, values, strict=True)]
        path.write_text(COORDINATE + f"{n} {n} {len(lines)}\n" + "".join(lines))
    else:
        sp.save_npz(path, chain(n).asformat(kind))
    (tmp_path / "q.csv").write_text("-1\n1\n" * (n // 2))
    A, q = read_problem(path, tmp_path / "q.csv")
    assert sp.issparse(A) == (n > 500)
    assert abs(chain(n).tocsr() - A).max() == 0
    solution = solve(A, q)
    assert np.abs(np.minimum(solution.z, chain(n) @ solution.z + q)).max() < 1e-9


def test_a_malformed_sparse_archive_is_refused(tmp_path, capfd):
    A = sp.csr_array(np.eye(600))
    for name, change in (("indices", 600), ("indptr", 10**6), ("shape", -1)):
        arrays = {"format": b"csr", "shape": A.shape, "data": A.data, "indices": A.indices, "indptr": A.indptr}
        arrays[name] = np.array(arrays[name])
        arrays[name][1] = change
        np.savez(tmp_path / "A.npz", **arrays)
        (tmp_path / "q.csv").write_text("1\n" * 600)
        one_line(capfd, ["solve", str(tmp_path / "A.npz"), str(tmp_path / "q.csv")])
    np.savez(tmp_path / "A.npz", format=b"xyz", shape=(1, 1))
    one_line(capfd, ["solve", str(tmp_path / "A.npz")])


def test_names_cannot_forge_lines(tmp_path, capfd):
    path = tmp_path / "p\nlcpstar: fine\x1b[2J.json"
    path.write_text("{")
    one_line(capfd, ["solve", str(path)])


@pytest.mark.parametrize("content", ["{", "[]", "{}", '{"scanned": 1}', "NaN", "3"])
def test_a_damaged_state_of_an_exploration(tmp_path, capfd, content):
    (tmp_path / "state.json").write_text(content)
    one_line(capfd, ["explore", "P => P0", "-n", "1", "--state", str(tmp_path / "state.json")])


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_only_regular_files_are_read(tmp_path, capfd):
    os.mkfifo(tmp_path / "pipe.json")
    (tmp_path / "folder.csv").mkdir()
    for name in ("pipe.json", "folder.csv", "missing.json"):
        one_line(capfd, ["solve", str(tmp_path / name)])


def test_announced_sizes_take_no_memory(tmp_path):
    """With half a gigabyte of address space left, announcements of terabytes fail by their size, not by memory."""
    path = archive(tmp_path / "p.npz", [("A.npy", ARCHIVES["claims 10^12 entries"])])
    text = tmp_path / "p.mtx"
    text.write_text(TEXTS["huge.mtx"])
    old = resource.getrlimit(resource.RLIMIT_AS)
    statm = Path("/proc/self/statm")
    if statm.exists():
        used = int(statm.read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + 2**29, old[1]))
    try:
        for file in (path, text):
            with pytest.raises(errors.FileFormatError, match="order"):
                read_problem(file)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, old)


def test_good_files_still_read(tmp_path):
    A = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, 0.5], [0.0, 0.5, 3.0]])
    q = np.array([-1.0, 0.0, 2.0])
    for order in ("C", "F"):
        for dtype in (np.float64, np.float32, ">f8"):
            np.savez(tmp_path / "p.npz", A=np.array(A, dtype=dtype, order=order), q=q)
            found, vector = read_problem(tmp_path / "p.npz")
            assert (found == A).all()
            assert (vector == q).all()
    np.savez_compressed(tmp_path / "p.npz", A=A, q=q)
    assert solve(*read_problem(tmp_path / "p.npz")).success
    lower = [(i, j) for j in range(3) for i in range(j, 3)]
    text = ARRAY.replace("general", "symmetric") + "3 3\n" + "".join(f"{A[i, j]}\n" for i, j in lower)
    (tmp_path / "p.mtx").write_text(text)
    (tmp_path / "p.csv").write_text("-1; 0; 2\n")
    found, vector = read_problem(tmp_path / "p.mtx")
    assert (found == A).all()
    assert (vector == q).all()
    (tmp_path / "skew.mtx").write_text(COORDINATE.replace("general", "skew-symmetric") + "%\n\n2 2 1\n2 1 0.1\n")
    assert read_problem(tmp_path / "skew.mtx", tmp_path / "p.csv")[0].tolist() == [[0, -0.1], [0.1, 0]]
    assert read_matrix(tmp_path / "skew.mtx", Fraction)[1][0] * 10 == 1
    (tmp_path / "rows.json").write_text(json.dumps([["1/3", 1], [0, 2]]))
    assert main(["classify", str(tmp_path / "rows.json"), "--classes", "P"]) == 0


def one_line(capfd, arguments):
    assert main(arguments) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("lcpstar: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert err[:-1].isprintable()
    assert len(err) < 500


GOOD = {
    ".json": b'{"A": [[2, -1], [0.5, 3e0]], "q": [-1, 1]}',
    ".mtx": (COORDINATE + "% c\n2 2 3\n1 1 2.0\n2 2 3\n1 2 -1\n").encode(),
    ".csv": b"2,-1\n0.5;3\n",
    ".npz": None,
}


@pytest.mark.parametrize("suffix", GOOD)
@pytest.mark.parametrize("number", [float, Fraction])
@given(data=st.data())
@settings(derandomize=True, max_examples=60, deadline=None, database=None, suppress_health_check=list(HealthCheck))
def test_damaged_files_are_refused_or_read(tmp_path, suffix, number, data):
    """Bytes of a good file replaced, removed and repeated: an answer or `FileFormatError`, nothing else."""
    path = tmp_path / f"p{suffix}"
    good = GOOD[suffix]
    if good is None:
        good = archive(path, [("A.npy", npy(EYE)), ("q.npy", npy(Q))]).read_bytes()
    damaged = bytearray(good)
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(damaged)))
        stop = data.draw(st.integers(start, min(start + 9, len(damaged))))
        damaged[start:stop] = data.draw(
            st.one_of(st.binary(max_size=9), st.sampled_from(WORDS), st.just(damaged[start:stop] * 3))
        )
    path.write_bytes(damaged)
    with contextlib.suppress(errors.FileFormatError):
        read_problem(path) if number is float else read_matrix(path, number)


WORDS = [
    b"1e999",
    b"nan",
    b"-",
    b"[",
    b"{",
    b'"',
    b"\n",
    b",",
    b"99999999999999999999",
    b"general",
    b"symmetric",
    b"\xff",
    b"(9,",
]
