"""What one call of `lcpstar.solve` costs from Python, beside QuantEcon's `lcp_lemke`: `python benches/call.py`."""

from __future__ import annotations

import lcpstar
from harness import residual, seconds_per_call, write_record
from lcpstar.problems import random_pd, random_spd
from peers import available


def main() -> None:
    peers = available(["quantecon"])
    lines = ["| problem | n | lcpstar.solve | quantecon lcp_lemke | ratio |", "| --- | --- | --- | --- | --- |"]
    data = []
    for family in (random_pd, random_spd):
        for n in (1, 2, 4, 8, 12, 16):
            A, q = family(n, seed=1)
            assert residual(A, q, lcpstar.solve(A, q).z) < 1e-9
            calls = {"lcpstar": lambda A=A, q=q: lcpstar.solve(A, q)}
            calls |= {name: lambda A=A, q=q, peer=peer: peer(A, q) for name, (peer, _) in peers.items()}
            times = seconds_per_call(calls)
            beside = times.get("quantecon", float("nan"))
            ours = times["lcpstar"]
            lines.append(
                f"| {family.__name__} | {n} | {1e6 * ours:.2f} us | {1e6 * beside:.2f} us | {beside / ours:.2f} |"
            )
            data.append({"family": family.__name__, "n": n, "times": times})
    write_record("call", "One call of solve", "python benches/call.py", "\n".join(lines), data)


if __name__ == "__main__":
    main()
