"""Tasks that judge every policy in the same way: named tasks, policies and score cards (docs/tasks.md).

python -m cournand.judge iliac --policy expert --episodes 20 --json card.json
"""

from .card import score, table
from .catalogue import CHALLENGES, SPLITS, Challenge, EpisodeSeed, challenge_of
from .expert import Expert
from .network import Network
from .play import Player, Row
from .policies import Linear, Policy, PolicyMaker, policy_of

__all__ = [
    "CHALLENGES",
    "SPLITS",
    "Challenge",
    "EpisodeSeed",
    "Expert",
    "Linear",
    "Network",
    "Player",
    "Policy",
    "PolicyMaker",
    "Row",
    "challenge_of",
    "policy_of",
    "score",
    "table",
]
