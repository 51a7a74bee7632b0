"""A deep policy for the named tasks, trained by proximal policy optimisation (PPO) with Stable-Baselines3. It is an
example for researchers (docs/tasks.md, "The deep baseline").

    python -m deep_baseline train iliac --steps 60000 --seed 1 --out iliac.npz
    python -m deep_baseline curves iliac.tsv --out curves.png
"""
