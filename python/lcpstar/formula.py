"""The language of `explore`: statements about a square matrix A, parsed into nested tuples for the compiled scan.

    claim     :=  formula => formula   |   formula          (a formula alone claims that it always holds)
    formula   :=  term { "|" term } ;  term := factor { "&" factor } ;  factor := "!" factor | "(" formula ")" | atom
    atom      :=  CLASS                                      "E0s", "C0*", "almost-P", "C0(2)", ...
               |  QUANTITY relation NUMBER                   v, det, rank, trace, n, min, max, a[i,j];  < <= > >= == !=
               |  MATRIX "in" scope                          A, A', A + A', A^-1, -A, A[0,2] (principal), ppt[0,2]
               |  ("every" | "some") FAMILY "in" scope       PPT, principal, proper principal, principal of order k
               |  symmetric | skew | bordered                bordered: A = [[A_aa, +], [-, 0]] with strict signs
    scope     :=  CLASS | "(" formula ")"

Indices count from 0. A PPT is meant up to a positive factor: compare only signs of its determinant or value.
"""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any, TypeAlias

from .classes.table import ALIASES, CLASSES, find_class
from .errors import OptionError

Tree: TypeAlias = tuple[Any, ...]

TRUE: Tree = ("and",)

_SYMBOLS = "|".join(
    re.escape(s) for s in sorted([*CLASSES, *(a for a in ALIASES if " " not in a)], key=len, reverse=True)
)
_TOKEN = re.compile(
    rf"""\s*(?:
      (?P<matrix>A\s*\+\s*A'|A'|A\^-1|-A(?![\w'])|A(?=\s+in\b|\s*\[)|ppt(?=\s*\[))
    | (?P<symbol>C0f?\(\d+\)|(?:{_SYMBOLS})(?![\w*+]))
    | (?P<number>[+-]?\d+(?:/\d+)?)
    | (?P<mark>=>|<=|>=|==|!=|<|>|&|\||!|\(|\)|\[|\]|,)
    | (?P<word>[A-Za-z]\w*)
    )""",
    re.VERBOSE,
)
_QUANTITIES = ("v", "det", "rank", "trace", "n", "min", "max")
_RELATIONS = ("<", "<=", ">", ">=", "==", "!=")


def parse_claim(text: str) -> tuple[Tree, Tree]:
    """(hypothesis, conclusion) of a claim.

    Raises
    ------
    OptionError
        With the place where the text stops making sense.
    """
    parser = _Parser(text)
    left = parser.formula()
    if parser.take("=>"):
        right = parser.formula()
        parser.end()
        return left, right
    parser.end()
    return TRUE, left


class _Parser:
    def __init__(self, text: str):
        self.text = text
        self.tokens: list[tuple[str, str, int]] = []
        position = 0
        stripped = text.rstrip()
        while position < len(stripped):
            match = _TOKEN.match(stripped, position)
            if match is None or match.lastgroup is None:
                raise OptionError(f"claim: cannot read {stripped[position:]!r} at column {position}")
            self.tokens.append((match.lastgroup, match[match.lastgroup], match.start(match.lastgroup)))
            position = match.end()
        self.next = 0

    def peek(self) -> tuple[str, str, int]:
        return self.tokens[self.next] if self.next < len(self.tokens) else ("end", "the end", len(self.text))

    def take(self, *values: str) -> str | None:
        kind, value, _ = self.peek()
        if value in values and kind in ("mark", "word"):
            self.next += 1
            return value
        return None

    def expect(self, value: str) -> None:
        if not self.take(value):
            self.fail(f"expected {value!r}")

    def fail(self, what: str) -> None:
        _, value, column = self.peek()
        raise OptionError(f"claim: {what}, got {value!r} at column {column} of {self.text!r}")

    def end(self) -> None:
        if self.peek()[0] != "end":
            self.fail("expected the end")

    def formula(self) -> Tree:
        parts = [self.term()]
        while self.take("|"):
            parts.append(self.term())
        return parts[0] if len(parts) == 1 else ("or", *parts)

    def term(self) -> Tree:
        parts = [self.factor()]
        while self.take("&"):
            parts.append(self.factor())
        return parts[0] if len(parts) == 1 else ("and", *parts)

    def factor(self) -> Tree:
        if self.take("!", "not"):
            return ("not", self.factor())
        if self.take("("):
            inner = self.formula()
            self.expect(")")
            return inner
        return self.atom()

    def scope(self) -> Tree:
        self.expect("in")
        if self.take("("):
            inner = self.formula()
            self.expect(")")
            return inner
        return self.symbol()

    def symbol(self) -> Tree:
        kind, value, _ = self.peek()
        if kind != "symbol":
            self.fail("expected a class symbol")
        self.next += 1
        return ("in", find_class(value).symbol)

    def atom(self) -> Tree:
        kind, value, _ = self.peek()
        if kind == "symbol":
            return self.symbol()
        if kind == "matrix":
            self.next += 1
            return self.of(value.replace(" ", ""))
        if quantifier := self.take("every", "some"):
            family = self.family()
            return (quantifier, family, self.scope())
        if word := self.take("symmetric", "skew", "bordered"):
            return (word,)
        if word := self.take(*_QUANTITIES, "a"):
            return self.comparison((word, *self.index_list(2)) if word == "a" else (word,))
        self.fail("expected a statement")
        raise AssertionError

    def of(self, matrix: str) -> Tree:
        if matrix in ("A", "ppt"):
            if self.peek()[1] == "[":
                mask = sum(1 << i for i in self.index_list())
                return ("of", ("principal" if matrix == "A" else "ppt", mask), self.scope())
            return self.scope()
        name = {"A'": "transpose", "A+A'": "symmetric", "A^-1": "inverse", "-A": "negative"}[matrix]
        return ("of", (name,), self.scope())

    def family(self) -> Tree:
        if self.take("PPT", "ppt"):
            return ("ppt",)
        if self.peek()[1] == "ppt":
            self.next += 1
            return ("ppt",)
        if self.take("proper"):
            self.expect("principal")
            return ("principal", 1, -1)
        self.expect("principal")
        if self.take("of"):
            self.expect("order")
            order = self.integer()
            return ("principal", order, order)
        return ("principal", 1, 0)

    def integer(self) -> int:
        kind, value, _ = self.peek()
        if kind != "number" or "/" in value or int(value) < 0:
            self.fail("expected an index")
        self.next += 1
        return int(value)

    def index_list(self, length: int | None = None) -> tuple[int, ...]:
        self.expect("[")
        indices = [self.integer()]
        while self.take(","):
            indices.append(self.integer())
        self.expect("]")
        if len(set(indices)) != len(indices) and length is None:
            self.fail("an index is repeated")
        if length is not None and len(indices) != length:
            self.fail(f"expected {length} indices")
        return tuple(indices)

    def comparison(self, quantity: Tree) -> Tree:
        relation = self.take(*_RELATIONS)
        if relation is None:
            self.fail("expected a relation")
        kind, value, _ = self.peek()
        if kind != "number":
            self.fail("expected a number")
        self.next += 1
        number = Fraction(value)
        return ("compare", quantity, relation, number.numerator, number.denominator)


def is_invariant(tree: Tree) -> bool:
    """Whether P A P' satisfies the formula whenever A does: no index and no border is named."""
    if tree[0] == "bordered" or (tree[0] in ("principal", "ppt") and len(tree) == 2) or tree[0] == "a":
        return False
    return all(is_invariant(part) for part in tree if isinstance(part, tuple))


def symbols(tree: Tree) -> list[str]:
    """The classes that a formula asks of A itself, in order."""
    if tree[0] == "in":
        return [tree[1]]
    if tree[0] in ("not", "and", "or"):
        found: list[str] = []
        for part in tree[1:]:
            found += [s for s in symbols(part) if s not in found]
        return found
    return []
