"""Environments of Gymnasium over machines: :class:`Env`, :class:`VectorEnv`, and ``gymnasium.make("arcline.gym:Arcline/Machine-v0")``. Needs ``gymnasium``."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from arcline._arcline import DEFAULT_CONFIG, Batch
from arcline.machine import Machine

__all__ = ["ID", "Env", "VectorEnv"]

#: The environment that is registered by importing this module: X shall go to a position that the seed draws.
ID = "Arcline/Machine-v0"

Array = npt.NDArray[np.float64]
#: Of observations, whose last axis is the signals, their rewards or whether they end an episode.
Judge = Callable[[Array], Any]
Bounds = Mapping[str, tuple[float, float]]

CONFIG = DEFAULT_CONFIG + '\n[[tag]]\nname = "Target"\ntype = "LREAL"\n\n[[tag]]\nname = "Goal"\ntype = "LREAL"\n'
PROGRAM = """
WHILE TRUE DO
    MAM(X, Move1, Absolute, 50 * Target, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, Trapezoidal, 100, 100, %ofTime, Enabled, Programmed);
    DELAY(0.01);
END_WHILE;
"""
OBSERVE: Bounds = {"X.ActualPosition": (-100.0, 100.0), "X.CommandVelocity": (-200.0, 200.0), "Goal": (-50.0, 50.0)}
ACT: Bounds = {"Target": (-1.0, 1.0)}
DRAW: Bounds = {"Goal": (-50.0, 50.0)}


def distance(observations: Array) -> Array:
    """The reward of the registered environment: less for each mm between X and its goal."""
    return -np.abs(observations[..., 0] - observations[..., 2]) / 100.0


class _Machines:
    """Machines that are stepped together, with what is observed of them, done to them and drawn for them."""

    def __init__(
        self,
        n: int,
        threads: int,
        config: str | os.PathLike[str] | None,
        program: str | None,
        observe: Bounds | Sequence[str],
        act: Bounds,
        draw: Bounds,
        ticks: int,
        until: float,
    ) -> None:
        if ticks < 1:
            raise ValueError(f"ticks is {ticks}, expected 1 or more")
        text = None if config is None else os.fspath(config)
        self.batch = Batch(text, n=n, threads=threads)
        self.program = program
        self.ticks = ticks
        self.steps = max(1, round(until / (ticks * Machine(text, journal=False).period)))
        self.act = dict(act)
        self.draw = dict(draw)
        self.drawn = {tag: np.zeros(n) for tag in self.draw}
        self.columns = [self.batch.bind(signal) for signal in observe]
        bounds = observe if isinstance(observe, Mapping) else {signal: (-np.inf, np.inf) for signal in observe}
        self.observation_space = box(bounds, np.float64)
        self.action_space = box(act, np.float32)
        self.count = np.zeros(n, dtype=np.int64)

    def begin(self, mask: npt.NDArray[np.bool_], generators: Sequence[np.random.Generator]) -> None:
        """Brings the machines of the mask back to their beginning."""
        self.batch.reset(mask)
        for tag, (low, high) in self.draw.items():
            for index in np.flatnonzero(mask):
                self.drawn[tag][index] = generators[int(index)].uniform(low, high)
            self.batch.write(tag, self.drawn[tag], mask)
        if self.program is not None:
            self.batch.program(self.program, mask=mask)
        self.count[mask] = 0
        self.batch.step(0)

    def step(self, actions: npt.NDArray[Any], mask: npt.NDArray[np.bool_]) -> None:
        """Writes a row of values for each machine of the mask, and lets the ticks of a step pass on all."""
        for column, (tag, (low, high)) in enumerate(self.act.items()):
            values = actions[:, column].astype(np.float64)
            for index in np.flatnonzero(np.isnan(values) & mask)[:1]:
                which = f"action of machine {index}" if len(values) > 1 else "action"
                raise ValueError(f"the {which} for {tag} is NaN, expected {low} to {high}")
        for column, (tag, (low, high)) in enumerate(self.act.items()):
            self.batch.write(tag, np.clip(actions[:, column].astype(np.float64), low, high), mask)
        self.batch.step(self.ticks)
        self.count += 1

    def observations(self) -> Array:
        return np.stack(self.columns, axis=-1)

    def infos(self) -> tuple[npt.NDArray[np.bool_], dict[str, Any]]:
        """Whether the program of each machine has failed, and the infos of a vector of environments, with the errors."""
        errors = self.batch.errors()
        failed = np.array([error is not None for error in errors])
        if not failed.any():
            return failed, {}
        column = np.empty(len(errors), dtype=object)
        column[:] = errors
        return failed, {"error": column, "_error": failed}

    def truncated(self, failed: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Whether the time of each episode is over, or its program has failed."""
        return (self.count >= self.steps) | failed


def box(bounds: Bounds, kind: type[np.floating[Any]]) -> gymnasium.spaces.Box:
    low, high = np.array(list(bounds.values()), dtype=kind).reshape(-1, 2).T
    return gymnasium.spaces.Box(low, high, dtype=kind)


class Env(gymnasium.Env[Any, Any]):
    """A machine as an environment.

    A step writes an action, a number for each tag of ``act`` within its bounds, and lets ``ticks`` ticks pass; the observation is the values of the signals
    ``observe`` then. ``program`` (Structured Text) is started at each reset, after the tags of ``draw`` were given values between their bounds, the only thing
    that the seed decides: the machine itself does the same for the same actions. ``reward`` and ``terminated`` are functions of an observation;
    an episode is truncated after ``until`` seconds. Without arguments X shall go to a drawn position.

    When the program fails, the episode is truncated, and ``info["error"]`` is the exception, as :attr:`arcline.Program.error` has it. It is truncated and
    not terminated, so that no agent learns to end an episode with negative rewards by an error; a wrapper may add a penalty. An action that is NaN is
    refused with a :class:`ValueError` and no time passes; one outside its bounds is clipped.

    >>> env = Env()
    >>> observation, info = env.reset(seed=1)
    >>> for _ in range(50):
    ...     observation, reward, terminated, truncated, info = env.step(observation[2:].astype("float32") / 50)
    >>> round(float(reward), 3), terminated, truncated
    (-0.0, False, False)
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        config: str | os.PathLike[str] | None = CONFIG,
        *,
        program: str | None = PROGRAM,
        observe: Bounds | Sequence[str] = OBSERVE,
        act: Bounds = ACT,
        draw: Bounds = DRAW,
        ticks: int = 20,
        until: float = 2.0,
        reward: Judge = distance,
        terminated: Judge | None = None,
    ) -> None:
        self._machines = _Machines(1, 1, config, program, observe, act, draw, ticks, until)
        self._reward = reward
        self._terminated = terminated
        self.observation_space = self._machines.observation_space
        self.action_space = self._machines.action_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Brings the machine back to its beginning."""
        super().reset(seed=seed)
        self._machines.begin(np.array([True]), [self.np_random])
        return self._machines.observations()[0], self._infos()[1]

    def step(self, action: npt.NDArray[np.float32]) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Writes an action and lets the ticks of a step pass."""
        self._machines.step(np.asarray(action).reshape(1, -1), np.array([True]))
        observation = self._machines.observations()[0]
        ended = self._terminated is not None and bool(self._terminated(observation))
        truncated, info = self._infos()
        return observation, float(self._reward(observation)), ended, truncated, info

    def _infos(self) -> tuple[bool, dict[str, Any]]:
        """Whether the episode is truncated, and its info."""
        failed, infos = self._machines.infos()
        return bool(self._machines.truncated(failed)[0]), {"error": infos["error"][0]} if infos else {}


class VectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """Many machines, stepped together on ``threads`` threads (0: all processors); machine ``i`` does what an :class:`Env` with the seed ``seed + i`` does.

    An episode that has ended is begun anew by the next step (``AutoresetMode.NEXT_STEP``), whose action for it is passed over.
    ``reset(options={"reset_mask": mask})`` begins those of the mask only. ``infos["error"]`` has the exceptions of programs, and ``infos["_error"]`` says of
    which machines; both are left out while no program has failed.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        config: str | os.PathLike[str] | None = CONFIG,
        *,
        threads: int = 0,
        program: str | None = PROGRAM,
        observe: Bounds | Sequence[str] = OBSERVE,
        act: Bounds = ACT,
        draw: Bounds = DRAW,
        ticks: int = 20,
        until: float = 2.0,
        reward: Judge = distance,
        terminated: Judge | None = None,
    ) -> None:
        self._machines = _Machines(num_envs, threads, config, program, observe, act, draw, ticks, until)
        self._reward = reward
        self._terminated = terminated
        self._ended = np.zeros(num_envs, dtype=bool)
        self._generators = [np.random.default_rng() for _ in range(num_envs)]
        self.num_envs = num_envs
        self.single_observation_space = self._machines.observation_space
        self.single_action_space = self._machines.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Brings all machines, or those of ``options["reset_mask"]``, back to their beginning."""
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, dtype=bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool:
            raise ValueError(f"reset_mask has shape {mask.shape} and type {mask.dtype}, expected ({self.num_envs},) and bool")
        seeds = [seed + index for index in range(self.num_envs)] if isinstance(seed, int) else seed
        for index, one in enumerate(seeds or []):
            if one is not None and mask[index]:
                self._generators[index] = gymnasium.utils.seeding.np_random(one)[0]
        self._machines.begin(mask, self._generators)
        self._ended[mask] = False
        return self._machines.observations(), self._machines.infos()[1]

    def step(
        self, actions: npt.NDArray[np.float32]
    ) -> tuple[Array, Array, npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]:
        """Writes the actions and lets the ticks of a step pass, or begins an episode anew where the last one has ended."""
        begun = self._ended.copy()
        self._machines.step(np.asarray(actions).reshape(self.num_envs, -1), ~begun)
        if begun.any():
            self._machines.begin(begun, self._generators)
        observations = self._machines.observations()
        rewards = np.where(begun, 0.0, np.asarray(self._reward(observations), dtype=np.float64))
        ended = np.zeros(self.num_envs, dtype=bool) if self._terminated is None else np.asarray(self._terminated(observations), dtype=bool) & ~begun
        failed, infos = self._machines.infos()
        # An episode whose program failed at its beginning is truncated by its first step, as that of an Env is.
        truncated = self._machines.truncated(failed) & ~begun
        self._ended = ended | truncated
        return observations, rewards, ended, truncated, infos


gymnasium.register(ID, entry_point="arcline.gym:Env", vector_entry_point="arcline.gym:VectorEnv")
