"""The noise of lower doses: measures the noise of a picture, and draws more of the same kind.

The quanta of a pixel follow Poisson's distribution. With *N* quanta, the logarithm has a deviation near 1 / sqrt(N), so
its square is inverse to the dose. A picture of the dose *D* therefore becomes one of the lower dose *d* if noise with
sqrt(D / d - 1) times its own deviation is added, at each place of the picture. That deviation differs from place to
place, because bones and contrast medium leave fewer quanta.
"""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

NOISE_CELL = 32  # pixels of the edge of a cell in which the deviation of the noise is measured
NORMAL = 0.6745  # the median of the absolute value of a normal number with the deviation 1
SHARES = (0.05, 0.22)  # of a pixel's noise that reach each neighbour in the scintillator, for fields of 32 to 14 cm
SECOND = torch.tensor([1.0, -2.0, 1.0])
# The second difference along rows and along columns: it removes the body, and keeps noise. White noise with the
# deviation 1 becomes noise with the deviation 6.
DIFFERENCE = torch.outer(SECOND, SECOND)[None, None]


def noise_of(pictures: Tensor) -> Tensor:
    """Returns the deviation of the noise in pictures float32 [n, size, size], for each cell: float32
    [n, size / NOISE_CELL, size / NOISE_CELL], in units of the pictures. It is the deviation of that white noise which
    has the same second differences. The median ignores the few pixels of tools and edges."""
    padded = functional.pad(pictures[:, None], (1, 1, 1, 1), mode="reflect")
    found = functional.conv2d(padded, DIFFERENCE).abs()
    cells = functional.pixel_unshuffle(found, NOISE_CELL)
    return cells.median(dim=1).values / (6.0 * NORMAL)


def response(share: float) -> float:
    """Returns the factor by which the second differences of white noise become smaller if each pixel gives `share` to
    its two neighbours along rows, and then along columns."""
    a = share
    return (2 * a**2 + 2 * (1 - 2 * a) ** 2 + (2 * a - 2) ** 2) / 6.0


def drawn_noise(deviations: Tensor, share: float) -> Tensor:
    """Draws noise whose neighbours share a part, as in a scintillator, float32 [rows, columns]. noise_of() finds the
    given deviations [rows, columns] in it."""
    rows, columns = deviations.shape
    white = torch.randn(1, 1, rows + 2, columns + 2)
    one = torch.tensor([share, 1.0, share])
    white = functional.conv2d(functional.conv2d(white, one.view(1, 1, 1, 3)), one.view(1, 1, 3, 1))
    return deviations * white[0, 0] / response(share)


def added_factor(dose_nGy: float, least_nGy: float, random: np.random.Generator) -> float:
    """Draws a dose between `least_nGy` and `dose_nGy`, evenly in its logarithm, and returns the deviation of the noise
    that makes a picture of this dose, in units of the deviation which the picture has."""
    if dose_nGy <= least_nGy:
        return 0.0
    drawn = least_nGy * (dose_nGy / least_nGy) ** random.uniform()
    return math.sqrt(dose_nGy / drawn - 1.0)
