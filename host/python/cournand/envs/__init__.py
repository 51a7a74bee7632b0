"""This package has the environments for Gymnasium; importing it registers them.

    import cournand.envs
    import gymnasium
    env = gymnasium.make("cournand/Aorta-v0", observation=("state", "fluoroscopy"), size=128)
    envs = gymnasium.make_vec("cournand/ArchBranch-v0", num_envs=64, vectorization_mode="vector_entry_point")

The guide to the environments is docs/gymnasium.md.
"""

from ..registration import register
from .navigation import EnvSnapshot, NavigationEnv, NavigationVectorEnv
from .task import AORTA, ARCH_BRANCH, TASKS, Exchange, Move, Randomise, Task

__all__ = [
    "AORTA",
    "ARCH_BRANCH",
    "TASKS",
    "EnvSnapshot",
    "Exchange",
    "Move",
    "NavigationEnv",
    "NavigationVectorEnv",
    "Randomise",
    "Task",
]

register()
