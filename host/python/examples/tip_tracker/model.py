"""The network of the tracker: an encoder and a decoder with links between them (U-Net), on cells of 4 × 4 pixels.

The input is the flattened logarithm of the detector's values. By Beer and Lambert's law, the logarithm turns the tool's
attenuation into a sum: the tool changes it by the same amount at each dose and in front of each tissue. A subtraction
of the mean over some 40 pixels then removes the body and keeps the tools.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

CELL = 4  # pixels of a cell's edge
BLUR = 5  # cells of 8 pixels over which flattened() takes the mean
WINDOW = 2  # cells on each side of the best cell that decide the place of the tip
BLADE_PART = 0.05  # of the median: what is darker is a blade of the collimator, or as dark as one
NONE = 8.0  # the score of the answer that a crop has no tip
GAIN = 8.0  # brings the contrast of guidewires, 0.05 to 0.3, near to 1
CHANNELS = (32, 48, 64, 96, 96)  # of the levels on the way down; the first needs many, for all directions of a wire
CHANNELS_UP = (16, 32, 48, 64)  # of the levels on the way up


def flattened(raw: Tensor) -> Tensor:
    """Returns the logarithm of detector values [n, 1, size, size] less its local mean. `size` is a multiple of 32. The
    mean leaves out the collimator's blades, where the detector sees almost nothing."""
    floor = BLADE_PART * raw.flatten(1).median(dim=1).values.clamp(min=1.0)[:, None, None, None]
    logarithm = torch.log(torch.maximum(raw, floor))
    is_seen = (raw > floor).float()
    coarse = functional.avg_pool2d(torch.cat([logarithm * is_seen, is_seen], dim=1), 8)
    blurred = functional.avg_pool2d(coarse, BLUR, stride=1, padding=BLUR // 2, count_include_pad=False)
    mean = (blurred[:, :1] + 1e-3 * torch.log(floor)) / (blurred[:, 1:] + 1e-3)
    return logarithm - functional.interpolate(mean, scale_factor=8.0, mode="bilinear", align_corners=False)


def _double(inside: int, outside: int) -> nn.Sequential:
    """Returns two convolutions of 3 × 3 with their normalisation."""
    parts: list[nn.Module] = []
    for channels in (inside, outside):
        parts += [nn.Conv2d(channels, outside, 3, padding=1, bias=False), nn.BatchNorm2d(outside), nn.ReLU()]
    return nn.Sequential(*parts)


class Tracker(nn.Module):
    """Maps flattened pictures [n, 1, size, size] to two maps of cells, float32 [n, 2, size / 4, size / 4]: a score of
    the tip, whose softmax over all cells is the distribution of the tip's place, and the logit of a tool's mask."""

    def __init__(self) -> None:
        super().__init__()
        inside = (CELL * CELL, *CHANNELS[:-1])
        self.down = nn.ModuleList([_double(a, b) for a, b in zip(inside, CHANNELS)])
        below = (*CHANNELS_UP[1:], CHANNELS[-1])
        levels = list(zip(below, CHANNELS, CHANNELS_UP))
        self.up = nn.ModuleList([_double(low + link, made) for low, link, made in reversed(levels)])
        self.head = nn.Conv2d(CHANNELS_UP[0], 2, 1)

    def forward(self, flat: Tensor) -> Tensor:
        found = functional.pixel_unshuffle(flat * GAIN, CELL).contiguous(memory_format=torch.channels_last)
        levels: list[Tensor] = []
        for number, block in enumerate(self.down):
            found = block(found if number == 0 else functional.max_pool2d(found, 2))
            levels.append(found)
        for number, block in enumerate(self.up):
            found = functional.interpolate(found, scale_factor=2.0, mode="nearest")
            found = block(torch.cat([found, levels[-2 - number]], dim=1))
        made: Tensor = self.head(found)
        return made


def target(tips: Tensor, cells: int, sigma: float = 1.0) -> Tensor:
    """Returns the wanted distribution of each tip, float32 [n, cells * cells + 1] with the sum 1: a Gaussian around the
    tip's place (column and row in pixels, [n, 2]) with `sigma` in cells. The last value is the probability that there
    is no tip: 1 if the tip is outside the picture."""
    middles = torch.arange(cells, dtype=torch.float32) + 0.5
    columns, rows = tips[:, 0:1] / CELL, tips[:, 1:2] / CELL
    across = torch.exp(-((middles - columns) ** 2) / (2 * sigma**2))
    along = torch.exp(-((middles - rows) ** 2) / (2 * sigma**2))
    made = (along[:, :, None] * across[:, None, :]).flatten(1)
    is_inside = ((tips >= 0) & (tips < cells * CELL)).all(dim=1, keepdim=True).float()
    made = is_inside * made / made.sum(dim=1, keepdim=True).clamp(min=1e-12)
    return torch.cat([made, 1 - is_inside], dim=1)


def loss(made: Tensor, tips: Tensor, masks: Tensor) -> Tensor:
    """Returns the loss of a batch: the cross entropy of the tip's distribution, in nats, and the mean cross entropy of
    the masks. The masks teach the network what a tool is, before it knows where one ends."""
    none = torch.full((len(made), 1), NONE)
    scores = functional.log_softmax(torch.cat([made[:, 0].flatten(1), none], dim=1), dim=1)
    tip = -(target(tips, made.shape[-1]) * scores).sum(dim=1).mean()
    weight = torch.tensor(8.0)  # some 2 % of the cells have a tool
    return tip + 2.0 * functional.binary_cross_entropy_with_logits(made[:, 1], masks, pos_weight=weight)


def chances_of(tracker: nn.Module, flat: Tensor, is_turned: bool = True) -> Tensor:
    """Returns the probability of each cell to hold the tip, float32 [n, size / CELL, size / CELL] with the sum 1. With
    `is_turned`, it is the mean over the eight ways to turn and flip a picture: the tip is the same in all of them."""
    if not is_turned:
        made = tracker(flat)[:, 0].float()
        return functional.softmax(made.flatten(1), dim=1).reshape(made.shape)
    total = torch.zeros(len(flat), *(edge // CELL for edge in flat.shape[2:]))
    for turns in range(4):
        for is_flipped in (False, True):
            seen = torch.rot90(flat, turns, (2, 3))
            chances = chances_of(tracker, seen.flip(3) if is_flipped else seen, is_turned=False)
            total += torch.rot90(chances.flip(2) if is_flipped else chances, -turns, (1, 2))
    return total / 8


def located(chances: Tensor) -> tuple[Tensor, Tensor]:
    """Returns the places of the tips in pixels, float32 [n, 2] as column and row, and the probability within the
    window, float32 [n], 0 to 1. The place is the mean of the distribution within a window around its best cell."""
    cells = chances.shape[-1]
    smooth = functional.avg_pool2d(chances[:, None], 3, stride=1, padding=1)
    best = smooth.flatten(1).argmax(dim=1)
    rows, columns = torch.div(best, cells, rounding_mode="floor"), best % cells
    grid = torch.arange(cells)
    near_rows = (grid - rows[:, None]).abs() <= WINDOW
    near_columns = (grid - columns[:, None]).abs() <= WINDOW
    inside = chances * near_rows[:, :, None] * near_columns[:, None, :]
    sums = inside.sum(dim=(1, 2))
    middles = (grid + 0.5) * CELL
    column = (inside.sum(dim=1) * middles).sum(dim=1) / sums.clamp(min=1e-12)
    row = (inside.sum(dim=2) * middles).sum(dim=1) / sums.clamp(min=1e-12)
    return torch.stack([column, row], dim=1), sums
