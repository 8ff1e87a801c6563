"""A stack that a careless solver drops: ten boxes, the top 10^6 times heavier, in real time.

`python examples/stack.py`
"""

from __future__ import annotations

import numpy as np

from lcpstar import scenes


def main() -> None:
    print("It stands: 1000 steps of 10 ms")
    scene = scenes.heavy_on_light(10, mass_ratio=1e6)
    history = scenes.run(scene, 1000)
    print(history)
    assert history.drift().max() < 1e-6

    print("\nPut down from 2 mm, 3 cm askew: it strikes and comes to rest")
    scene = scenes.heavy_on_light(10, mass_ratio=1e6)
    scene.position[:, 0] += np.random.default_rng(0).uniform(-0.03, 0.03, 10)
    scene.position[:, 2] += 0.002 * np.arange(1, 11)
    print(scenes.run(scene, 300))

    print("\nFour pivots a step, and no more: it falls, and the history says why")
    scene = scenes.heavy_on_light(10, mass_ratio=1e6)
    print(scenes.run(scene, 100, method="lemke", max_iterations=4))


if __name__ == "__main__":
    main()
