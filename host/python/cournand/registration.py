"""Registers the environments with Gymnasium when `cournand.envs` is imported."""

from __future__ import annotations

TASKS = {"cournand/Aorta-v0": "aorta", "cournand/ArchBranch-v0": "arch_branch"}
"""The name of each environment, and of its task in cournand.envs.TASKS."""


def register() -> None:
    """Registers the environments; importing `cournand.envs` calls it."""
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
