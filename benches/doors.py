"""The stress campaign through the Python face: problems that mislead for all doors, scored by an exact referee.

`make stress` runs it after the campaign of the core. Doors: `solve` with right and wrong guesses, in exact arithmetic,
by named methods, with sparse matrices, views of all layouts and float32; `solve_batch` plain, with one A, with guesses,
with `out`; `verify` with genuine and forged answers, A sparse or dense, of floats or `Fraction`s; `accuracy`. Findings
are printed with their problem.
"""

from __future__ import annotations

import argparse
import math
import pathlib
import sys
import time
from collections import Counter, defaultdict
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import scipy.sparse

import lcpstar
from attacks import ATTACKS, embedded, problem
from forgeries import forged
from referee import ENUMERATED, Problem, WrongError, score

CHUNK = 16
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-9, 1e-9, 1e-12, 1e-14)
METHODS = (
    "lemke",
    "principal_pivoting",
    "block_pivoting",
    "enumerate",
    "bilinear",
    "interior_point",
    "newton",
    "pgs",
    "pgs_sm",
    "nncg",
    "apgd",
    "admm",
)
SPARSE = ("auto", "interior_point", "newton", "pgs", "pgs_sm", "nncg", "apgd", "admm")
FORMATS = (scipy.sparse.csr_array, scipy.sparse.csc_array, scipy.sparse.coo_array, scipy.sparse.csr_matrix)
REFUTED = ("infeasible", "nearly_infeasible")


def _within_record(x):
    record = np.zeros(x.shape, [("flag", "i4"), ("x", "f8")])
    record["x"] = x
    return record["x"]


def _strided(x):
    wide = np.full([3 * k for k in x.shape], 7.0)
    view = wide[tuple(slice(1, None, 3) for _ in x.shape)]
    view[...] = x
    return view


def _odd_address(x):
    view = np.zeros(x.nbytes + 1, np.uint8)[1:].view(float).reshape(x.shape)
    view[...] = x
    return view


def _read_only(x):
    x = x.copy()
    x.setflags(write=False)
    return x


VIEWS = {
    "record": _within_record,
    "strided": _strided,
    "odd address": _odd_address,
    "backwards": lambda x: np.flip(np.flip(x).copy()),
    "Fortran order": np.asfortranarray,
    "transposed": lambda x: np.ascontiguousarray(x.T).T,
    "big-endian": lambda x: x.astype(">f8"),
    "read-only": _read_only,
    "list": lambda x: x.tolist(),
}


class Campaign:
    """Counts per door, and the findings."""

    def __init__(self, seed):
        self.seed, self.problems = seed, 0
        self.counts = defaultdict(Counter)
        self.findings = []

    def found(self, door, kind, what, case, tol):
        self.counts[door][kind] += 1
        self.findings.append(f"{door}: {what}\n  tol = {tol}, {case if case.n <= 8 else f'n = {case.n}'}")
        print(self.findings[-1], file=sys.stderr, flush=True)

    def judge(self, door, case, sol, tol):
        """Scores one answer. Whether it may be built upon."""
        try:
            self.counts[door][score(case, sol, tol)] += 1
        except WrongError as error:
            self.found(
                door,
                "wrong",
                f"{sol.status} by {getattr(sol, 'method', '?')}: {error}; z = {sol.z.tolist()}",
                case,
                tol,
            )
            return False
        return True

    def same(self, door, case, one, other, tol):
        """Two answers to the same numbers must be the same bits."""
        equal = str(one.status) == str(other.status) and all(
            np.array_equal(getattr(one, name), getattr(other, name))
            for name in ("z", "w", "residual", "natural_residual")
        )
        if equal:
            self.counts[door]["right"] += 1
        else:
            self.found(door, "wrong", f"{one.status} {one.z} and {other.status} {other.z}", case, tol)

    def attack(self, chunk):
        """One chunk of problems of one attack, order and tolerance."""
        rng = np.random.default_rng([self.seed, chunk])
        n = int(rng.choice([1, 2, 2, 3, 3, 4, 4, 5, 6, 8]))
        tol = float(rng.choice(TOLERANCES))
        family = ATTACKS[chunk % len(ATTACKS)]
        cases = [Problem(*problem(rng, family, n)) for _ in range(CHUNK)]
        self.problems += CHUNK
        answers = [self.alone(case, tol, rng, k) for k, case in enumerate(cases)]
        self.batches(cases, answers, tol, rng)
        self.embedded(cases[0], tol, rng)

    def alone(self, case, tol, rng, k):
        """Every door for one problem, those that cost more in turn."""
        A, q, n = case.A, case.q, case.n
        sol = lcpstar.solve(A, q, tol=tol)
        if self.judge("solve", case, sol, tol):
            self.verify(case, sol, tol, rng)
        if k % 2:
            guess = (rng.random(n) < 0.5) * 10.0 ** rng.uniform(-3, 3, n)
            self.judge("wrong z0", case, lcpstar.solve(A, q, tol=tol, z0=guess), tol)
        elif np.isfinite(sol.z).all():
            self.judge("right z0", case, lcpstar.solve(A, q, tol=tol, z0=np.maximum(sol.z, 0)), tol)
        name = str(rng.choice(list(VIEWS)))
        view = VIEWS[name]
        self.same(f"view: {name}", case, lcpstar.solve(view(A), view(q), tol=tol), sol, tol)
        if k % 4 == 0:
            proved = lcpstar.solve(A, q, tol=tol, certify="exact")
            if self.judge("exact", case, proved, tol):
                self.verify(case, proved, tol, rng, exact=proved.certificate is not None and proved.certificate.exact)
            self.same("exact, view", case, lcpstar.solve(view(A), view(q), tol=tol, certify="exact"), proved, tol)
        elif k % 4 == 1:
            method = str(rng.choice(METHODS))
            named = lcpstar.solve(A, q, tol=tol, method=method)
            if self.judge("named methods", case, named, tol):
                self.verify(case, named, tol, rng)
        elif k % 4 == 2:
            form = FORMATS[int(rng.integers(len(FORMATS)))]
            sparse = lcpstar.solve(form(A), q, tol=tol, method=str(rng.choice(SPARSE)))
            if self.judge("sparse", case, sparse, tol):
                self.verify(case, sparse, tol, rng, A=form(A))
        else:
            self.single(case, tol)
        self.accuracy(case, sol, tol, rng)
        return sol

    def single(self, case, tol):
        """float32 numbers are the doubles that equal them."""
        top = np.finfo(np.float32).max
        A, q = (np.clip(x, -top, top).astype(np.float32) for x in (case.A, case.q))
        rounded = Problem(A, q)
        sol = lcpstar.solve(A, q, tol=tol)
        self.judge("float32", rounded, sol, tol)
        self.same("float32", rounded, sol, lcpstar.solve(rounded.A, rounded.q, tol=tol), tol)
        batch = lcpstar.solve_batch(A[None], q[None], tol=tol)
        self.same(
            "batch, float32",
            rounded,
            _of_batch(batch, 0),
            _of_batch(lcpstar.solve_batch(rounded.A[None], rounded.q[None], tol=tol), 0),
            tol,
        )

    def verify(self, case, sol, tol, rng, A=None, exact=False):
        """The genuine answer is accepted, forged ones are refused."""
        if A is None:
            A = case.A if rng.random() < 0.9 else [[Fraction(x) for x in row] for row in case.A]
        report = lcpstar.verify(A, case.q, sol, tol=tol, exact=exact and sol.status == "solved")
        if report:
            self.counts["verify, genuine"]["right"] += 1
        else:
            what = f"{sol.status}: {[(c.name, c.detail) for c in report.failures]}; z = {sol.z.tolist()}"
            self.found("verify, genuine", "wrong", what, case, tol)
        for name, forgery in forged(rng, case, sol):
            door = f"verify, {name}"
            try:
                accepted = bool(lcpstar.verify(A, case.q, forgery, tol=tol))
            except Exception as error:
                self.found(door, "wrong", f"verify raised {error!r}", case, tol)
                continue
            if not accepted:
                self.counts[door]["refused"] += 1
                continue
            try:
                score(case, forgery, tol, loose=True)
                self.counts[door]["still true"] += 1
            except Exception as error:
                self.found(door, "wrong", f"accepted: {error} in {vars(forgery)}", case, tol)

    def accuracy(self, case, sol, tol, rng):
        """The bound, where there is one, is not below the exact error."""
        if case.n > ENUMERATED:
            return
        z = sol.z
        match rng.integers(4):
            case 0:
                z = np.maximum(z * (1 + 10.0 ** rng.uniform(-15, 0) * rng.standard_normal(case.n)), 0.0)
            case 1:
                z = np.ldexp(1.0, rng.integers(-1000, 1000, case.n))
        found = lcpstar.accuracy(case.A, case.q, z)
        if found.error_bound is None:
            self.counts["accuracy"]["no"] += 1
            return
        error = max(
            (abs(Fraction(x) - y) for s in case.solutions for x, y in zip(z, s, strict=True)), default=Fraction(0)
        )
        good = case.is_solvable and (math.isinf(found.error_bound) or error <= Fraction(found.error_bound))
        if good:
            self.counts["accuracy"]["right"] += 1
        else:
            what = f"bound {found.error_bound} of z = {z.tolist()}, solutions {case.solutions}"
            self.found("accuracy", "wrong", what, case, tol)

    def batches(self, cases, answers, tol, rng):
        """The whole chunk at once, in every way."""
        A, q = np.array([case.A for case in cases]), np.array([case.q for case in cases])
        plain = lcpstar.solve_batch(A, q, tol=tol)
        whole = [_of_batch(plain, k) for k in range(CHUNK)]
        for case, sol in zip(cases, whole, strict=True):
            self.refuted(case, sol, tol)
            self.judge("batch", case, sol, tol)
        out = lcpstar.solve_batch(A[::-1], q[::-1], tol=tol)
        view = VIEWS[str(rng.choice(list(VIEWS)))]
        again = {
            "batch, out": lcpstar.solve_batch(A, q, tol=tol, out=out),
            "batch, view": lcpstar.solve_batch(view(A), view(q), tol=tol),
            "batch, threads": lcpstar.solve_batch(A, q, tol=tol, threads=2),
        }
        for door, batch in again.items():
            for k, case in enumerate(cases):
                self.same(door, case, _of_batch(batch, k), whole[k], tol)
        n = cases[0].n
        wrong = rng.integers(0, 2**n, CHUNK).astype(np.uint64)
        guessed = {
            "batch, right alpha0": lcpstar.solve_batch(A, q, tol=tol, alpha0=plain.alpha),
            "batch, wrong alpha0": lcpstar.solve_batch(A, q, tol=tol, alpha0=wrong),
            "batch, right z0": lcpstar.solve_batch(A, q, tol=tol, z0=np.array([np.maximum(s.z, 0) for s in answers])),
        }
        for door, batch in guessed.items():
            for k, case in enumerate(cases):
                sol = _of_batch(batch, k)
                self.refuted(case, sol, tol)
                self.judge(door, case, sol, tol)
        shared = lcpstar.solve_batch(cases[0].A, q, tol=tol)
        for k in range(CHUNK):
            case, sol = Problem(cases[0].A, cases[k].q), _of_batch(shared, k)
            self.refuted(case, sol, tol)
            self.judge("batch, one A", case, sol, tol)

    def refuted(self, case, sol, tol):
        """A batch hands over no certificate: `solve` must have one for the same status."""
        if sol.status in REFUTED:
            alone = lcpstar.solve(case.A, case.q, tol=tol)
            sol.certificate = alone.certificate
            if alone.status != sol.status:
                self.found("batch", "wrong", f"{sol.status} in a batch, {alone.status} alone", case, tol)

    def embedded(self, case, tol, rng):
        """Where no dense copy is made: a small problem that decides about a large sparse one."""
        if case.n > ENUMERATED:
            return
        A, q = embedded(rng, case.A, case.q)
        large = Problem(A, q, core=case)
        form = FORMATS[int(rng.integers(len(FORMATS)))](A)
        self.problems += 1
        for method in ("auto", str(rng.choice(SPARSE[1:]))):
            sol = lcpstar.solve(form, q, tol=tol, method=method)
            if self.judge("sparse, n > 128", large, sol, tol):
                self.verify(large, sol, tol, rng, A=form)


def _of_batch(batch, k):
    mask = int(batch.alpha[k])
    return SimpleNamespace(
        z=batch.z[k].copy(),
        w=batch.w[k].copy(),
        status=str(batch.status[k]),
        method=batch.method[k],
        residual=float(batch.residual[k]),
        natural_residual=float(batch.natural_residual[k]),
        alpha=[i for i in range(batch.z.shape[-1]) if mask >> i & 1],
        certificate=None,
    )


HEAD = "| door | right | of these nearly | honest no | forgeries refused | changed, still true | wrong |"
PREFACE = """## Through the Python face

`benches/doors.py` asks through the doors of the Python package; another exact referee, in Python integers, scores each
answer and each number in it. Doors named "view" must give the bits that a copy of the same numbers gives. `verify`
must accept each genuine answer, and refuse each one of which a field was changed unless what it says is still true. A
bound of `accuracy` must not be below the exact error.
"""


def tables(campaign, seconds, command):
    lines = [PREFACE, f"{summary(campaign)} in {seconds:.0f} s (`{command}`).", "", HEAD, "| --- |" + " --- |" * 6]
    for door, count in sorted(campaign.counts.items()):
        right = count["right"] + count["nearly"]
        shown = (door, right, count["nearly"], count["no"], count["refused"], count["still true"], count["wrong"])
        lines.append(f"| {' | '.join(map(str, shown))} |")
    return "\n".join(lines) + "\n"


def summary(campaign):
    total = sum(campaign.counts.values(), Counter())
    forgeries = total["refused"] + total["still true"]
    answers = sum(total.values()) - forgeries
    accepted = sum(c["wrong"] for door, c in campaign.counts.items() if door.startswith("verify, "))
    accepted -= campaign.counts["verify, genuine"]["wrong"]
    return (
        f"{campaign.problems} problems, {answers} answers, {forgeries} forgeries: {total['wrong']} wrong, "
        f"{accepted} forgeries accepted"
    )


def run(count, seed, progress=False):
    """About `count` problems."""
    campaign, begun = Campaign(seed), time.monotonic()
    for chunk in range(math.ceil(count / CHUNK)):
        if campaign.problems >= count:
            break
        campaign.attack(chunk)
        if progress and chunk % 200 == 199:
            print(f"{summary(campaign)}, {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
    return campaign


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=5000, help="problems, about")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--record", type=pathlib.Path, help="append to docs/stress.md and benches/record/stress.md below it"
    )
    given = parser.parse_args()
    begun = time.monotonic()
    campaign = run(given.count, given.seed, progress=True)
    command = f"benches/doors.py --count {given.count} --seed {given.seed}"
    text = tables(campaign, time.monotonic() - begun, command)
    print(text)
    if given.record:
        for name in ("docs/stress.md", "benches/record/stress.md"):
            path = given.record / name
            core = path.read_text().split(PREFACE.splitlines()[0])[0].rstrip()
            path.write_text(f"{core}\n\n{text}")
    return 1 if campaign.findings else 0


if __name__ == "__main__":
    sys.exit(main())
