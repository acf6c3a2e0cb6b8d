"""The environments of Gymnasium: its own checks, a machine beside many, and episodes that end and begin."""

import doctest

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import arcline.gym
from arcline.gym import ID, Env, VectorEnv


def test_gymnasium_finds_nothing_amiss(recwarn):
    env = gymnasium.make(ID)
    check_env(env.unwrapped, skip_render_check=True)
    assert not [str(warning.message) for warning in recwarn.list]
    assert doctest.testmod(arcline.gym).failed == 0


def test_many_machines_do_what_one_does():
    vector = gymnasium.make_vec(ID, num_envs=5, vectorization_mode="vector_entry_point", until=0.2)
    assert vector.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    singles = [Env(until=0.2) for _ in range(5)]
    vector.action_space.seed(3)
    observations, _ = vector.reset(seed=40)
    expected = [env.reset(seed=40 + index)[0] for index, env in enumerate(singles)]
    np.testing.assert_array_equal(observations, expected)
    assert len({row[2] for row in expected}) == 5, "each has a goal of its own"
    ends = 0
    for step in range(35):
        actions = vector.action_space.sample()
        observations, rewards, terminated, truncated, _ = vector.step(actions)
        assert observations.shape == (5, 3) and observations in vector.observation_space
        if step % 11 == 10:
            # The step behind the end of an episode begins the next one.
            expected = [env.reset()[0] for env in singles]
            assert not rewards.any() and not truncated.any()
        else:
            results = [env.step(action) for env, action in zip(singles, actions)]
            expected = [result[0] for result in results]
            assert rewards.tolist() == [result[1] for result in results]
            assert truncated.tolist() == [result[3] for result in results] == [step % 11 == 9] * 5
            ends += int(truncated[0])
        np.testing.assert_array_equal(observations, expected)
        assert not terminated.any()
    assert ends == 3


def test_some_machines_begin_anew():
    vector = VectorEnv(3)
    first, _ = vector.reset(seed=1)
    for _ in range(5):
        before, *_ = vector.step(np.full((3, 1), 0.6, dtype=np.float32))
    assert (before[:, 0] > 1.0).all()
    after, _ = vector.reset(seed=1, options={"reset_mask": np.array([True, False, True])})
    np.testing.assert_array_equal(after[[0, 2]], first[[0, 2]])
    np.testing.assert_array_equal(after[1], before[1])
    with pytest.raises(ValueError, match="reset_mask"):
        vector.reset(options={"reset_mask": np.array([True])})


def test_tags_program_and_end_are_those_of_the_caller():
    env = Env(
        None,
        program="MAM(X, Move1, Absolute, 20, Move2.Speed, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);",
        observe=["X.ActualPosition", "Move2.Speed"],
        act={"FeedOverride[0]": (0.0, 200.0)},
        draw={"Move2.Speed": (100.0, 100.0)},
        reward=lambda observation: observation[..., 0],
        terminated=lambda observation: observation[..., 0] >= 20.0,
    )
    observation, _ = env.reset()
    assert observation.tolist() == [0.0, 100.0]
    for steps in range(1, 40):
        observation, reward, terminated, truncated, _ = env.step(np.array([100.0], dtype=np.float32))
        if terminated:
            break
    assert (observation[0], reward, truncated) == (20.0, 20.0, False)
    assert 10 <= steps <= 20
    with pytest.raises(arcline.TagError):
        Env(observe=["X.Position"])


COUNTS = arcline.gym.CONFIG
COUNT = {
    "program": "WHILE TRUE DO Goal := Goal + 1; DELAY(0.01); END_WHILE;",
    "observe": ["Goal"],
    "act": {"Target": (-1.0, 1.0)},
    "draw": {"Goal": (0.0, 50.0)},
    "reward": lambda observation: observation[..., 0],
    "terminated": lambda observation: observation[..., 0] >= 60.0,
}


def test_an_episode_that_begins_leaves_the_others_as_they_are():
    vector, singles = VectorEnv(4, COUNTS, **COUNT), [Env(COUNTS, **COUNT) for _ in range(4)]
    observations, _ = vector.reset(seed=1)
    expected = [env.reset(seed=1 + index)[0] for index, env in enumerate(singles)]
    np.testing.assert_array_equal(observations, expected)
    ended, begun = [False] * 4, 0
    for _ in range(60):
        observations, _, terminated, _, _ = vector.step(np.zeros((4, 1), dtype=np.float32))
        for index, env in enumerate(singles):
            if ended[index]:
                expected, ended[index] = env.reset()[0], False
                begun += 1
            else:
                expected, _, ended[index], *_ = env.step(np.zeros(1, dtype=np.float32))
            np.testing.assert_array_equal(observations[index], expected)
        assert terminated.tolist() == ended
    assert begun >= 4


SPEED = {
    "program": "MAM(X, Move1, Absolute, 20, Target, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2); WAIT(Move1.PC);",
    "observe": ["X.ActualPosition"],
    "act": {"Goal": (-1.0, 1.0)},
    "draw": {"Target": (-100.0, 100.0)},
    "reward": lambda observation: observation[..., 0],
}


def test_an_error_of_the_program_truncates_the_episode_and_is_in_its_info():
    vector, singles = VectorEnv(6, COUNTS, **SPEED), [Env(COUNTS, **SPEED) for _ in range(6)]
    _, infos = vector.reset(seed=0)
    starts = [env.reset(seed=index)[1] for index, env in enumerate(singles)]
    wrong = ["error" in info for info in starts]
    assert 0 < sum(wrong) < 6
    assert infos["_error"].tolist() == wrong and infos["_error"].dtype == bool
    _, rewards, terminated, truncated, infos = vector.step(np.zeros((6, 1), dtype=np.float32))
    steps = [env.step(np.zeros(1, dtype=np.float32)) for env in singles]
    assert truncated.tolist() == wrong == [step[3] for step in steps] and not terminated.any()
    for index, (*_, info) in enumerate(steps):
        assert ("error" in info) == wrong[index] == bool(infos["_error"][index])
        if wrong[index]:
            assert type(info["error"]) is arcline.MotionError and (info["error"].err, info["error"].exerr) == (13, 4)
            assert infos["error"][index].args == info["error"].args
        else:
            assert infos["error"][index] is None
    # The next step begins these machines anew, with another speed.
    _, _, _, truncated, infos = vector.step(np.zeros((6, 1), dtype=np.float32))
    assert not truncated[np.logical_not(wrong)].any()
    env = Env()
    assert env.reset(seed=1)[1] == {} == env.step(np.zeros(1, dtype=np.float32))[4]


def test_an_action_that_is_no_number_is_refused():
    env, vector = Env(), VectorEnv(3, until=0.04)
    env.reset(seed=1)
    vector.reset(seed=1)
    with pytest.raises(ValueError, match="the action for Target is NaN"):
        env.step(np.array([np.nan], dtype=np.float32))
    actions = np.array([[0.5], [np.nan], [0.5]], dtype=np.float32)
    with pytest.raises(ValueError, match="the action of machine 1 for Target is NaN"):
        vector.step(actions)
    # The refused actions have changed nothing.
    assert env.step(np.zeros(1, dtype=np.float32))[0][0] == 0.0
    for _ in range(2):
        *_, truncated, _ = vector.step(np.zeros((3, 1), dtype=np.float32))
    assert truncated.all()
    # Machines that this step begins anew pass their action over.
    observations, *_ = vector.step(np.full((3, 1), np.nan, dtype=np.float32))
    assert np.isfinite(observations).all()
