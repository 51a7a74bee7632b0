"""Environments for Gymnasium.

    import gymnasium
    env = gymnasium.make("cournand/Aorta-v0", observation=("state", "fluoroscopy"), size=128)
    envs = gymnasium.make_vec("cournand/ArchBranch-v0", num_envs=64, vectorization_mode="vector_entry_point")

The page docs/gymnasium.md is the guide. Gymnasium finds these environments itself when the package is installed.
"""

from .navigation import EnvSnapshot, NavigationEnv, NavigationVectorEnv
from .task import ARCH_BRANCH, AORTA, Randomise, Task

TASKS = {"cournand/Aorta-v0": AORTA, "cournand/ArchBranch-v0": ARCH_BRANCH}


def register() -> None:
    """Registers the environments; Gymnasium calls it by the package's entry point."""
    from gymnasium.envs import registration

    for name, task in TASKS.items():
        if name not in registration.registry:
            registration.register(
                name,
                entry_point="cournand.envs.navigation:NavigationEnv",
                vector_entry_point="cournand.envs.navigation:NavigationVectorEnv",
                kwargs={"task": task},
                order_enforce=False,
                disable_env_checker=True,
            )


__all__ = [
    "AORTA",
    "ARCH_BRANCH",
    "TASKS",
    "EnvSnapshot",
    "NavigationEnv",
    "NavigationVectorEnv",
    "Randomise",
    "Task",
    "register",
]
