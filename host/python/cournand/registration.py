"""Registers the environments with Gymnasium when `cournand.envs` is imported."""

from __future__ import annotations

TASKS = {"cournand/Aorta-v0": "aorta", "cournand/ArchBranch-v0": "arch_branch"}
"""The name of each environment without drawn anatomies, and of its task in cournand.envs.TASKS."""
CHALLENGES = {
    "cournand/Iliac-v1": "iliac",
    "cournand/Subclavian-v1": "subclavian",
    "cournand/Brachiocephalic-v1": "brachiocephalic",
    "cournand/LeftCarotid-v1": "left_carotid",
    "cournand/ShippedArch-v1": "shipped_arch",
    "cournand/ArchVariety-v1": "arch_variety",
    "cournand/TwoDevices-v1": "two_devices",
}
"""The name of each environment of a named task, and of this task in cournand.tasks.CHALLENGES. The number after `-v` is
the version of the task."""


def register() -> None:
    """Registers the environments; importing `cournand.envs` calls it."""
    for name, task in TASKS.items():
        place = "cournand.envs.navigation:Navigation"
        _register(name, place + "Env", place + "VectorEnv", {"task": task})
    for name, challenge in CHALLENGES.items():
        place = "cournand.tasks.environments:"
        _register(name, place + "single", place + "vector", {"challenge": challenge})


def _register(name: str, single: str, vector: str, arguments: dict[str, str]) -> None:
    from gymnasium.envs import registration

    if name not in registration.registry:
        registration.register(
            name,
            entry_point=single,
            vector_entry_point=vector,
            kwargs=arguments,
            order_enforce=False,
            disable_env_checker=True,
        )
