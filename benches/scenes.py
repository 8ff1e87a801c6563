"""Scenes: a heavy top on light boxes for 1000 steps, a hundred stacks in one scene, what each scene costs.

`python benches/scenes.py`. Processor time; every step's answer is checked by `solve`, and drift and physical errors are
measured on the motion.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import lcpstar
from harness import write_record
from lcpstar import scenes

#: Seconds that a step may take in real time at 60 frames a second.
BUDGET = 0.016
#: Methods beside "auto"; those that this build does not know are left out.
METHODS = ("lemke", "interior_point", "pgs", "pgs_sm", "nncg", "apgd", "admm", "newton")


def known(method: str) -> bool:
    try:
        lcpstar.solve([[1.0]], [-1.0], method=method)
    except lcpstar.errors.UnknownNameError:
        return False
    return True


def stepped(scene: scenes.Scene, steps: int, **settings) -> tuple[scenes.History, np.ndarray]:
    """The history, and processor seconds per step."""
    stepper, history, seconds = scenes.Stepper(scene, **settings), scenes.History(scene), []
    for _ in range(steps):
        start = time.process_time()
        record = stepper.step()
        seconds.append(time.process_time() - start)
        history.add(scene, record)
    return history, np.array(seconds)


def put_down(scene: scenes.Scene) -> scenes.Scene:
    """Boxes shifted sideways by up to 3 cm and 2 mm above one another: they fall, strike and come to rest."""
    n = len(scene)
    scene.position[:, 0] += np.random.default_rng(0).uniform(-0.03, 0.03, n)
    scene.position[:, 2] += 0.002 * np.arange(1, n + 1)
    return scene


def standing(steps: int) -> tuple[list[str], list[dict]]:
    """Ten boxes, the top 10^6 times heavier."""
    cases = {
        "plane": lambda: scenes.heavy_on_light(10, mass_ratio=1e6),
        "plane, put down": lambda: put_down(scenes.heavy_on_light(10, mass_ratio=1e6)),
        "space": lambda: scenes.heavy_on_light(10, mass_ratio=1e6, planar=False),
    }
    lines = [
        "| scene | method | rows | solved steps | ms a step, median | ms, longest | top sinks, m | largest drift, m "
        "| penetration, m | energy drift, J |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    data = []
    for name, make in cases.items():
        for method in ("auto", *filter(known, METHODS)):
            scene = make()
            settings = {} if method == "auto" else {"method": method, "time_limit": BUDGET}
            history, seconds = stepped(scene, steps, **settings)
            rest = 9.5  # where the centre of the top belongs
            fallen = rest - float(history.position[-1, -1, 2])
            settled = history.position[min(200, steps // 2) :] - history.position[min(200, steps // 2)]
            drift = float(np.sqrt(np.square(settled).sum(axis=2)).max())
            row = {
                "scene": name,
                "method": method,
                "rows": int(history.largest.max()),
                "solved": int(history.solved.sum()),
                "steps": steps,
                "median_ms": 1e3 * float(np.median(seconds)),
                "max_ms": 1e3 * float(seconds.max()),
                "fallen": fallen,
                "drift": drift,
                "penetration": float(history.penetration.max()),
                "energy": float(history.energy_drift[-1]),
            }
            data.append(row)
            lines.append(
                f"| {name} | {method} | {row['rows']} | {row['solved']} of {steps} | {row['median_ms']:.2f} "
                f"| {row['max_ms']:.1f} | {fallen:.1e} | {drift:.1e} | {row['penetration']:.1e} | {row['energy']:.2e} |"
            )
            print(lines[-1], flush=True)
            if method == "auto":
                assert abs(fallen) < 1e-6, fallen
    return lines, data


def crowds(rounds: int) -> tuple[list[str], list[dict]]:
    """A hundred stacks in one scene beside a hundred scenes; the same bits."""
    lines = [
        "| stacks | boxes | | rows in all | one scene, ms a step | scenes apart, ms a step | ratio | same bits |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    data = []
    for boxes, planar in ((1, True), (3, True), (10, True), (4, False)):
        scene = scenes.box_stack(boxes, mass_ratio=100.0, stacks=100, planar=planar, spacing=3.0)
        scene.velocity[:, 0] = np.random.default_rng(1).uniform(-0.2, 0.2, len(scene))
        alone = [scene.subset(range(k * boxes, (k + 1) * boxes)) for k in range(100)]
        together, apart = scenes.Stepper(scene), [scenes.Stepper(one) for one in alone]
        one_scene, many = [], []
        for _ in range(rounds):
            start = time.process_time()
            record = together.step()
            middle = time.process_time()
            for stepper in apart:
                stepper.step()
            many.append(time.process_time() - middle)
            one_scene.append(middle - start)
        same = all(
            np.array_equal(getattr(scene, field), np.concatenate([getattr(one, field) for one in alone]))
            for field in ("position", "orientation", "velocity", "angular_velocity")
        )
        assert same
        a, b = float(np.median(one_scene)), float(np.median(many))
        data.append({"boxes": boxes, "planar": planar, "rows": record.rows, "one": a, "apart": b})
        lines.append(
            f"| 100 | {boxes} | {'plane' if planar else 'space'} | {record.rows} | {1e3 * a:.1f} | {1e3 * b:.1f} "
            f"| {a / b:.2f} | {'yes' if same else 'no'} |"
        )
        print(lines[-1], flush=True)
    return lines, data


def catalogue(steps: int) -> tuple[list[str], list[dict]]:
    """Every generator for some steps by "auto"."""
    made = {
        "box_stack(10)": lambda: scenes.box_stack(10),
        "box_stack(10, mass_ratio=1e8)": lambda: scenes.box_stack(10, mass_ratio=1e8),
        "box_stack(10, planar=False)": lambda: scenes.box_stack(10, planar=False),
        "pyramid_wall(5)": lambda: scenes.pyramid_wall(5),
        "arch(15, 0.16)": lambda: scenes.arch(15, 0.16),
        "arch(15, 0.05)": lambda: scenes.arch(15, 0.05),
        "card_house(3)": lambda: scenes.card_house(3),
        "card_house(3, friction=0.1)": lambda: scenes.card_house(3, friction=0.1),
        "chain(10, height=1.5, angle=1.2)": lambda: scenes.chain(10, height=1.5, angle=1.2),
        "sphere_pile(64)": lambda: scenes.sphere_pile(64),
        "sphere_pile(64, mass_ratio=1e4)": lambda: scenes.sphere_pile(64, mass_ratio=1e4),
        "sphere_pile(32, friction=0.3)": lambda: scenes.sphere_pile(32, friction=0.3),
    }
    lines = [
        "| scene | bodies | rows, largest LCP | islands | solved steps | ms a step, median | ms, longest | drift, m "
        "| penetration, m | penetration velocity, m/s | cone, N s | Signorini, J |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    data = []
    for name, make in made.items():
        scene = make()
        h, seconds = stepped(scene, steps)
        row = {
            "scene": name,
            "bodies": len(scene),
            "largest": int(h.largest.max()),
            "islands": int(h.islands.max()),
            "solved": int(h.solved.sum()),
            "steps": steps,
            "median_ms": 1e3 * float(np.median(seconds)),
            "max_ms": 1e3 * float(seconds.max()),
            "drift": float(h.drift()[-1]),
            "penetration": float(h.penetration.max()),
            "penetration_velocity": float(h.penetration_velocity.max()),
            "cone": float(h.cone_violation.max()),
            "signorini": float(h.signorini.max()),
        }
        data.append(row)
        lines.append(
            f"| {name} | {row['bodies']} | {row['largest']} | {row['islands']} | {row['solved']} of {steps} "
            f"| {row['median_ms']:.2f} | {row['max_ms']:.1f} | {row['drift']:.2g} | {row['penetration']:.1e} "
            f"| {row['penetration_velocity']:.1e} | {row['cone']:.1e} | {row['signorini']:.1e} |"
        )
        print(lines[-1], flush=True)
    return lines, data


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=1000)
    options = parser.parse_args()
    stands, stood = standing(options.steps)
    crowd, crowded = crowds(max(5, options.steps // 50))
    scene, measured = catalogue(max(20, options.steps // 5))
    text = "\n".join(
        [
            f"Ten boxes of mass 1, the top 10^6 times heavier, {options.steps} steps of 10 ms. Methods other than "
            f'"auto" have {1e3 * BUDGET:.0f} ms a step. Drift is counted from step {min(200, options.steps // 2)}.',
            "",
            *stands,
            "",
            "A hundred stacks, kicked sideways, in one scene and as a hundred scenes, in turns:",
            "",
            *crowd,
            "",
            f'{max(20, options.steps // 5)} steps of 10 ms by "auto":',
            "",
            *scene,
        ]
    )
    data = {"standing": stood, "crowds": crowded, "scenes": measured}
    write_record("scenes", "Contact scenes, one thread, processor time", "python benches/scenes.py", text, data)


if __name__ == "__main__":
    main()
