"""PPO learns on the environment: a smoke run of the agent of skrl, on JAX. Needs skrl, jax, flax and optax, which take 600 MB and are in no list of requirements:

pip install skrl jax flax optax
"""

import numpy as np
import pytest

skrl = pytest.importorskip("skrl")
linen = pytest.importorskip("flax.linen")
jax = pytest.importorskip("jax")

from arcline.gym import VectorEnv  # noqa: E402

ENVS = 8
STEPS = 1_280
SCALE = np.array([100.0, 200.0, 50.0])


def machines():
    """X is at its goal after a few steps of 0.1 s."""
    return VectorEnv(ENVS, ticks=100, until=1.0)


def rewards(act):
    """The mean reward of a step of ten episodes of each machine, the same ones in every call."""
    env = machines()
    observations, _ = env.reset(seed=1000)
    total = []
    for _ in range(110):
        observations, reward, *_ = env.step(act(observations))
        total.append(reward)
    return float(np.mean(total))


def test_ppo_learns_to_go_to_the_goal(tmp_path):
    from skrl.agents.jax.ppo import PPO, PPO_CFG
    from skrl.envs.wrappers.jax import wrap_env
    from skrl.memories.jax import RandomMemory
    from skrl.models.jax import DeterministicMixin, GaussianMixin, Model
    from skrl.trainers.jax import SequentialTrainer
    from skrl.utils import set_seed

    set_seed(7)

    class Policy(GaussianMixin, Model):
        def __init__(self, **spaces):
            Model.__init__(self, **spaces)
            GaussianMixin.__init__(self, clip_actions=True)

        @linen.compact
        def __call__(self, inputs, role):
            x = inputs["observations"] / SCALE
            for width in (32, 32):
                x = linen.tanh(linen.Dense(width)(x))
            deviation = self.param("deviation", lambda _: -0.5 * jax.numpy.ones(1))
            # Untrained it goes nowhere, whatever the seed.
            return linen.Dense(1, kernel_init=linen.initializers.zeros)(x), {"log_std": deviation}

    class Value(DeterministicMixin, Model):
        def __init__(self, **spaces):
            Model.__init__(self, **spaces)
            DeterministicMixin.__init__(self)

        @linen.compact
        def __call__(self, inputs, role):
            x = inputs["observations"] / SCALE
            for width in (32, 32):
                x = linen.tanh(linen.Dense(width)(x))
            return linen.Dense(1)(x), {}

    env = wrap_env(machines(), wrapper="gymnasium")
    spaces = {"observation_space": env.observation_space, "action_space": env.action_space, "device": env.device}
    models = {"policy": Policy(**spaces), "value": Value(**spaces)}
    for role, model in models.items():
        model.init_state_dict(role=role)
    cfg = PPO_CFG(rollouts=64, learning_epochs=8, mini_batches=4, learning_rate=2e-3, discount_factor=0.8, rewards_shaper=lambda rewards, *_: rewards * 10)
    cfg.experiment.directory = str(tmp_path)
    cfg.experiment.write_interval = cfg.experiment.checkpoint_interval = 0
    memory = RandomMemory(memory_size=cfg.rollouts, num_envs=ENVS, device=env.device)
    agent = PPO(models=models, memory=memory, cfg=cfg, **spaces)

    def act(observations):
        _, outputs = models["policy"].act({"observations": jax.numpy.asarray(observations)}, role="policy")
        return np.asarray(outputs["mean_actions"], dtype=np.float32)

    untrained = rewards(act)
    SequentialTrainer(cfg={"timesteps": STEPS, "headless": True, "disable_progressbar": True}, env=env, agents=agent).train()
    trained = rewards(act)
    # The best action, which is to go to the goal at once, and to stay, for comparison.
    best, still = rewards(lambda rows: (rows[:, 2:] / 50.0).astype(np.float32)), rewards(lambda rows: np.zeros((ENVS, 1), np.float32))
    print(f"untrained {untrained:.3f}, trained {trained:.3f}, best {best:.3f}, standing still {still:.3f}")
    assert untrained == pytest.approx(still) and best > still
    assert trained - still > 0.5 * (best - still)
