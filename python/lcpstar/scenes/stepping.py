"""Time stepping: find contacts, solve each island, move. Semi-implicit Euler, velocity-level contacts. [ST96]."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..coerce import Matrix, Vector
from ..errors import OptionError
from ..options import MethodOptions
from .assembly import Island, Stepping, System
from .body import positive
from .collide import find_contacts, margins, motion
from .contact import Contacts, Indices
from .history import History, StepRecord
from .joints import close_joints, joint_errors
from .measures import PhysicalErrors, physical_errors
from .rotation import dot, turn
from .scene import Scene
from .solving import Answer, Solving, solve_islands

#: Contacts left out are put back when their new normal velocity is below minus this many roundings of its terms.
_ROUNDINGS = 64 * np.finfo(float).eps
#: Contacts are looked for this often in a step at most; each time for twice the motion found.
_SEARCHES = 10


@dataclass(frozen=True, eq=False)
class _Impulses:
    """Last step's answer by contact: identity, normal impulse, facets' impulses, sliding speed."""

    identity: NDArray[np.int64]
    z: Matrix


class Stepper:
    """Moves a scene in steps of `dt` seconds. `run` is the loop around it; its parameters are explained there."""

    def __init__(
        self,
        scene: Scene,
        dt: float = 0.01,
        method: str = "auto",
        tol: float = 1e-9,
        max_iterations: int | None = None,
        time_limit: float | None = None,
        options: MethodOptions | None = None,
        warm_start: bool = True,
        facets: int = 4,
        stabilisation: float = 0.2,
        bounce_speed: float = 0.1,
        reach: float = 10.0,
        sleep_speed: float = 0.0,
        sleep_after: float = 0.5,
    ) -> None:
        positive("dt", dt)
        positive("sleep_after", sleep_after)
        if not 0 <= stabilisation <= 1:
            raise OptionError(f"stabilisation must lie in [0, 1], got {stabilisation}")
        for name, value in (("bounce_speed", bounce_speed), ("reach", reach), ("sleep_speed", sleep_speed)):
            if not value >= 0:
                raise OptionError(f"{name} must be nonnegative, got {value}")
        self.scene = scene
        self.stepping = Stepping(dt, facets, stabilisation, bounce_speed, reach)
        self.solving = Solving(method, tol, max_iterations, time_limit, options, warm_start)
        self.sleep_speed, self.sleep_after = sleep_speed, sleep_after
        self.contacts = Contacts.of([])
        self.islands: list[Island] = []
        self._identity = self.contacts.identity()
        self._last: _Impulses | None = None
        self._error: Matrix | None = None

    def step(self) -> StepRecord:
        """One step: changes the scene's state and returns what happened. `contacts` and `islands` keep the problems."""
        start = time.perf_counter()
        scene, dt = self.scene, self.stepping.dt
        scene.check_finite()
        close_joints(scene)  # what the caller has moved apart
        margin = margins(scene, dt)
        solve_seconds = 0.0
        limit = self.solving.time_limit
        deadline = None if limit is None else time.perf_counter() + limit
        for _ in range(_SEARCHES):
            self.contacts = find_contacts(scene, dt, margin)
            self._identity = self.contacts.identity()
            system = System(scene, self.contacts, self.stepping, self._error)
            started = time.perf_counter()
            solved, asleep, u = self._solve(system, deadline)
            solve_seconds += time.perf_counter() - started
            moved = motion(scene, *system.masses.unpack(u), dt)
            shot = moved > margin  # impulses made it faster than contacts were looked for
            if not shot.any() or _over(deadline):
                break
            margin = np.where(shot, 2 * moved, margin)
        impulses = [(island, answer.z) for island, answer in solved]
        self._error = system.rounding(impulses)
        u = np.where(np.abs(u) <= self._error, 0.0, u)  # what rounding alone may have made is rest
        errors = physical_errors(system, impulses, u)
        self._remember(solved)
        self.islands = [island for island, _ in solved]
        self._move(system, u, asleep)
        return _record(self.scene, solved, asleep, errors, solve_seconds, time.perf_counter() - start)

    def _solve(
        self, system: System, deadline: float | None
    ) -> tuple[list[tuple[Island, Answer]], NDArray[np.bool_], Matrix]:
        """Solve the islands; while a contact that was left out acts, put it back and solve its islands again."""
        included = system.may_act()
        done: dict[int, tuple[Island, Answer]] = {}
        while True:
            home = system.island_of(included)
            asleep = self._asleep(home)
            awake = np.unique(home[(home >= 0) & ~asleep]).tolist()
            missing = [i for i in awake if i not in done]
            islands = system.islands(included, home, missing)
            answers = solve_islands(islands, [self._guess(island) for island in islands], self.solving, deadline)
            done |= {i: (island, answer) for i, island, answer in zip(missing, islands, answers, strict=True)}
            solved = [done[i] for i in awake]
            u = system.velocity([(island, answer.z) for island, answer in solved])
            u[asleep] = 0.0
            late = ~included & self._acts(system, u)
            if not late.any() or _over(deadline):
                return solved, asleep, u
            included = included | late
            touched = set(system.island_of(included)[self.contacts.bodies[late]].ravel().tolist())
            done = {i: both for i, both in done.items() if i not in touched}

    @staticmethod
    def _acts(system: System, u: Matrix) -> NDArray[np.bool_]:
        moving = system.normals.times(u)
        scale = np.abs(moving) + np.abs(system.b) + system.settings.dt
        return np.asarray(moving + system.b < -_ROUNDINGS * scale)

    def _asleep(self, home: Indices) -> NDArray[np.bool_]:
        """Bodies of islands in which every body has been still for long enough."""
        if self.sleep_speed == 0:
            return np.zeros(len(home), dtype=bool)
        restless = np.zeros(len(home), dtype=bool)
        moves = home >= 0
        restless[home[moves & (self.scene.still < self.sleep_after)]] = True
        return np.asarray(moves & ~restless[np.where(moves, home, 0)])

    def _guess(self, island: Island) -> Vector | None:
        """Last step's impulses for the contacts that were there, 0 for the others; None without any."""
        last = self._last
        if last is None or not self.solving.warm_start or not len(island.contacts):
            return None
        identity = self._identity[island.contacts]
        at = np.minimum(np.searchsorted(last.identity, identity), max(0, len(last.identity) - 1))
        known = len(last.identity) > 0 and last.identity[at] == identity
        if not np.any(known):
            return None
        z = np.where(np.asarray(known)[:, None], last.z[at], 0.0)
        rubbing = z[island.rubbing]
        return np.concatenate([z[:, 0], rubbing[:, 1:-1].ravel(), rubbing[:, -1]])

    def _remember(self, solved: list[tuple[Island, Answer]]) -> None:
        contacts = np.concatenate([i.contacts for i, _ in solved] + [np.empty(0, np.intp)]).astype(np.intp)
        facets = 2 if self.scene.planar else self.stepping.facets
        z = np.zeros((len(contacts), facets + 2))
        first = 0
        for island, answer in solved:
            k, m = len(island.contacts), len(island.rubbing)
            z[first : first + k, 0] = answer.z[:k]
            z[first + island.rubbing, 1:-1] = answer.z[k : k + m * facets].reshape(m, facets)
            z[first + island.rubbing, -1] = answer.z[k + m * facets :]
            first += k
        identity = self._identity[contacts]
        order = np.argsort(identity)
        self._last = _Impulses(identity[order], z[order])

    def _move(self, system: System, u: Matrix, asleep: NDArray[np.bool_]) -> None:
        scene, dt = self.scene, self.stepping.dt
        scene.velocity, scene.angular_velocity = system.masses.unpack(u)
        scene.position = scene.position + dt * scene.velocity
        scene.orientation = turn(scene.orientation, scene.angular_velocity, dt)
        shift, turns = close_joints(scene)
        scene.velocity, scene.angular_velocity = scene.velocity + shift / dt, scene.angular_velocity + turns / dt
        scene.time += dt
        if self.sleep_speed > 0:
            speed = np.sqrt(dot(scene.velocity, scene.velocity))
            speed = speed + scene.radius * np.sqrt(dot(scene.angular_velocity, scene.angular_velocity))
            scene.still = np.where(speed <= self.sleep_speed, scene.still + dt, 0.0)


def _over(deadline: float | None) -> bool:
    return deadline is not None and time.perf_counter() >= deadline


def _record(
    scene: Scene,
    solved: list[tuple[Island, Answer]],
    asleep: NDArray[np.bool_],
    errors: PhysicalErrors,
    solve_seconds: float,
    seconds: float,
) -> StepRecord:
    answers = [answer for _, answer in solved]
    energy = scene.energy()
    return StepRecord(
        time=scene.time,
        rows=sum(len(island.q) for island, _ in solved),
        largest=max((len(island.q) for island, _ in solved), default=0),
        islands=len(solved),
        asleep=int(asleep.sum()),
        solved=all(answer.success for answer in answers) and bool(np.isfinite(energy)),
        methods=tuple(sorted({answer.method for answer in answers})),
        iterations=sum(answer.iterations for answer in answers),
        residual=max((answer.residual for answer in answers), default=0.0),
        natural_residual=max((answer.natural_residual for answer in answers), default=0.0),
        errors=errors,
        energy=energy,
        joint_error=float(joint_errors(scene).max(initial=0.0)),
        solve_seconds=solve_seconds,
        seconds=seconds,
    )


def run(
    scene: Scene,
    steps: int,
    dt: float = 0.01,
    method: str = "auto",
    tol: float = 1e-9,
    max_iterations: int | None = None,
    time_limit: float | None = None,
    options: MethodOptions | None = None,
    warm_start: bool = True,
    facets: int = 4,
    stabilisation: float = 0.2,
    bounce_speed: float = 0.1,
    reach: float = 10.0,
    sleep_speed: float = 0.0,
    sleep_after: float = 0.5,
) -> History:
    """Move `scene` (changed in place) by `steps` steps of `dt` seconds.

    Parameters
    ----------
    scene : Scene
    steps : int
    dt : float [s]
    method, tol, max_iterations, options
        As in `lcpstar.solve`, for every island of every step. An island that is not solved moves with the best point
        found; `History.solved` and `History.residual` say so.
    time_limit : float [s], optional
        For all LCPs of one step together.
    warm_start : bool
        Start from last step's impulses at the contacts that are still there.
    facets : int
        Of the friction cone in space. In a planar scene two are exact, and this is ignored.
    stabilisation : float in [0, 1]
        Fraction of a penetration that one step takes back.
    bounce_speed : float [m/s]
        Slower impacts do not bounce.
    reach : float
        Contacts that would open faster than `reach dt |g|` without impulses are left out, and put back if they act.
    sleep_speed : float [m/s], sleep_after : float [s]
        An island whose bodies have all been slower than `sleep_speed` (speed plus spin times bounding radius) for
        `sleep_after` seconds is not solved and stays where it is, until an awake body joins it. 0: nothing sleeps.

    Returns
    -------
    History

    Raises
    ------
    OptionError, UnknownNameError
        An option out of range.
    NotFiniteError
        The scene's state holds NaN or inf when a step begins.

    Notes
    -----
    `v_new = v + dt g + M^-1 J' z` with z from LCPs (see `assembly`), then `x_new = x + dt v_new`: first order, and
    without restitution and stabilisation the energy does not grow (frictional and normal impulses do no positive work).
    [ST96], [AP97].

    Examples
    --------
    >>> from lcpstar import scenes
    >>> history = scenes.run(scenes.box_stack(3), steps=10)
    >>> bool(history.solved.all()), float(history.drift().max()) < 1e-9
    (True, True)
    """
    stepper = Stepper(
        scene,
        dt,
        method,
        tol,
        max_iterations,
        time_limit,
        options,
        warm_start,
        facets,
        stabilisation,
        bounce_speed,
        reach,
        sleep_speed,
        sleep_after,
    )
    history = History(scene)
    for _ in range(steps):
        history.add(scene, stepper.step())
    return history
