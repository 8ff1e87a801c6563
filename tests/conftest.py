"""Fixtures: the corpus of published problems, where it is there."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def corpus():
    """Paths of the published problems; skips without `LCPSTAR_CORPUS`."""
    folder = os.environ.get("LCPSTAR_CORPUS")
    if not folder:
        pytest.skip("LCPSTAR_CORPUS is not set: published problems are read from there")
    paths = sorted(Path(folder).glob("*.npz"))
    assert paths, f"no .npz file in {folder}"
    return paths
