"""Scenes that stand, lean or fall, their islands, sleep and warm starts."""

from __future__ import annotations

import numpy as np
import pytest

from lcpstar import errors, scenes
from lcpstar.scenes import Body, Box, Scene
from scene_checks import kicked

# Structures -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("mass_ratio", [1.0, 1e3, 1e6, 1e8])
def test_heavy_on_light_stands(planar, mass_ratio):
    scene = scenes.heavy_on_light(10, mass_ratio=mass_ratio, planar=planar)
    history = scenes.run(scene, 60)
    assert history.solved.all()
    assert history.drift().max() < 1e-9


def test_a_stack_that_is_put_down_comes_to_rest():
    scene = scenes.heavy_on_light(10, mass_ratio=1e6)
    scene.position[:, 0] += np.random.default_rng(0).uniform(-0.03, 0.03, 10)
    scene.position[:, 2] += 0.002 * np.arange(1, 11)
    history = scenes.run(scene, 120)
    assert history.solved.all()
    assert np.abs(history.position[-1, :, 2] - (0.5 + np.arange(10))).max() < 1e-6
    assert history.drift()[-1] - history.drift()[-30] < 1e-9
    assert history.energy_drift[-1] < 0


@pytest.mark.parametrize(("thickness", "stands"), [(0.2, True), (0.14, True), (0.07, False), (0.05, False)])
def test_an_arch_stands_when_it_is_thick_enough(thickness, stands):
    """Heyman: t/R >= 0.106 for a semicircle with joints everywhere."""
    drift = scenes.run(scenes.arch(15, thickness), 150).drift()[-1]
    assert drift < 1e-6 if stands else drift > 0.1


def test_walls_arch_and_cards_lean_by_friction():
    assert scenes.run(scenes.pyramid_wall(4), 60).drift()[-1] < 1e-9
    assert scenes.run(scenes.card_house(2), 60).drift()[-1] < 1e-9
    assert scenes.run(scenes.card_house(2, friction=0.1), 100).drift()[-1] > 0.2
    without_middle = [0, 2, 3, 4, 5]
    arching = scenes.pyramid_wall(3, friction=0.5).subset(without_middle)
    assert scenes.run(arching, 60).drift()[-1] < 1e-9
    falling = scenes.pyramid_wall(3, friction=0.05).subset(without_middle)
    assert scenes.run(falling, 60).drift()[-1] > 1e-3


# Islands, order, sleep ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("boxes", "planar"), [(1, True), (2, True), (5, True), (3, False)])
def test_stacks_in_one_scene_have_the_bits_of_stacks_alone(boxes, planar):
    stacks = 12
    scene = kicked(scenes.box_stack(boxes, mass_ratio=50.0, stacks=stacks, planar=planar, spacing=3.0), 2)
    scene.position[:, 2] += 0.003 * np.tile(np.arange(boxes), stacks)
    alone = [scene.subset(range(k * boxes, (k + 1) * boxes)) for k in range(stacks)]
    together = scenes.Stepper(scene)
    apart = [scenes.Stepper(one) for one in alone]
    for _ in range(25):
        record = together.step()
        records = [stepper.step() for stepper in apart]
        assert record.islands >= stacks
        assert record.rows == sum(r.rows for r in records)
        for name in ("position", "orientation", "velocity", "angular_velocity"):
            assert np.array_equal(getattr(scene, name), np.concatenate([getattr(one, name) for one in alone])), name


@pytest.mark.parametrize(("rows", "apart"), [(2, 1e-9), (4, 2e-3)])
def test_order_of_bodies_is_physics_of_its_own(rows, apart):
    """Contact with friction has many solutions in a wall; the order of the bodies decides, by less than a slip."""
    scene = kicked(scenes.pyramid_wall(rows), 7, 0.1)
    order = np.random.default_rng(0).permutation(len(scene))
    other = scene.subset(order)
    a, b = scenes.run(scene, 20), scenes.run(other, 20)
    assert a.solved.all()
    assert b.solved.all()
    assert np.abs(scene.position[order] - other.position).max() < apart
    assert np.isclose(a.energy[-1], b.energy[-1], atol=10 * apart)


def test_sleep_and_waking():
    scene = scenes.box_stack(3, stacks=2, spacing=4.0)
    missile = Body(Box((0.2, 0.2, 0.2)), 5.0, (4.0, 0, 6.0), velocity=(0, 0, 0))
    scene = Scene([*scene.bodies, missile], scene.planes, planar=True)
    history = scenes.run(scene, 120, sleep_speed=0.01, sleep_after=0.2)
    assert history.asleep[25] == 6
    assert history.rows[25] == 0
    hit = np.flatnonzero(history.asleep[25:] == 3)  # the struck stack wakes, the other sleeps on
    assert len(hit) > 0
    assert history.rows[25 + hit[0]] > 0
    assert history.position[-1, 6, 2] > 3.0
    assert (history.position[-1, :3] == history.position[30, :3]).all()


def test_nothing_falls_asleep_unless_asked():
    history = scenes.run(scenes.box_stack(2), 100)
    assert history.asleep.max() == 0


def test_slow_motion_is_not_mistaken_for_rounding():
    scene = Scene([Body(Box((0.5, 0.5, 0.5)), 1.0, (0, 0, 0.5), velocity=(1e-9, 0, 0), friction=0.0)], planar=True)
    scenes.run(scene, 100)
    assert np.isclose(scene.position[0, 0], 1e-9, rtol=1e-6)


def test_warm_start_finds_the_same_motion():
    cold, warm = (kicked(scenes.box_stack(4), 4, 0.05) for _ in range(2))
    a = scenes.run(cold, 60, warm_start=False)
    b = scenes.run(warm, 60)
    assert "warm_start" not in a.methods
    assert "warm_start" in b.methods
    assert np.abs(cold.position - warm.position).max() < 1e-9


def test_an_answer_that_is_not_solved_is_said_and_used():
    scene = scenes.box_stack(5)
    history = scenes.run(scene, 3, method="lemke", max_iterations=1)
    assert not history.solved.any()
    assert history.residual.min() > 1e-6
    assert history.penetration_velocity.max() > 1e-3
    assert "solved in 0 of 3" in str(history)


def test_a_step_without_time_moves_on_and_says_so():
    scene = scenes.sphere_pile(16, friction=0.3)
    history = scenes.run(scene, 60, method="lemke", time_limit=1e-9)
    assert len(history) == 60
    assert not history.solved.all()
    assert np.isfinite(scene.position).all()


def test_a_state_that_is_not_finite_is_never_solved():
    scene = Scene([Body(Box((0.1, 0.2, 0.3)), 1.0, (0, 0, 5), angular_velocity=(1e200, 1e199, 0))])
    with np.errstate(all="ignore"):
        assert not scenes.run(scene, 1).solved.any()
    scene = scenes.box_stack(1)
    scene.velocity[0, 2] = np.nan
    with pytest.raises(errors.NotFiniteError, match=r"velocity must be finite, got velocity\[0, 2\] = nan"):
        scenes.run(scene, 1)


def test_history_has_an_array_for_every_number():
    history = scenes.run(scenes.box_stack(2), 5)
    for name in ("time", "rows", "islands", "residual", "seconds", "penetration", "signorini", "energy"):
        assert getattr(history, name).shape == (5,)
    assert history.position.shape == (6, 2, 3)
    assert history.energy_drift.shape == history.drift().shape == (5,)
    with pytest.raises(AttributeError, match="nonsense"):
        _ = history.nonsense
