"""Changes of a good series, for the table odd_series.py: those of its slices before they are written, and those of the
folder afterwards.
"""

import math
import os
import random

import odd_dicom as dicom


def each(work):
    """A change of every slice."""

    def change(slices):
        for number, one in enumerate(slices):
            work(number, one)
        return slices

    return change


def put(tag, value):
    return each(lambda number, one: one.put(tag, value))


def drop(*tags):
    return each(lambda number, one: one.drop(*tags))


def only(index, work):
    def change(slices):
        work(slices[index])
        return slices

    return change


def without(*gone, counted=False):
    def change(slices):
        left = [one for number, one in enumerate(slices) if number not in gone]
        return left if counted else [one.drop(dicom.COUNT) for one in left]

    return change


def spaced(place_mm):
    """Moves slice n along the body to place_mm(n)."""

    def work(number, one):
        one.move(z_mm=place_mm(number) - 2.0 * number)

    return each(work)


def copied(index, work):
    """One more file: a copy of a slice, changed."""

    def change(slices):
        more = slices[index].copy("more.dcm")
        work(more)
        return slices + [more]

    return change


def renamed(name_of):
    def work(number, one):
        one.name = name_of(number)

    return each(work)


def turned(axes):
    """Other directions of rows and columns, with the positions that go with them."""
    row, column = axes[:3], axes[3:]
    normal = [
        row[1] * column[2] - row[2] * column[1],
        row[2] * column[0] - row[0] * column[2],
        row[0] * column[1] - row[1] * column[0],
    ]

    def work(number, one):
        first = [-26.0 * row[i] - 26.0 * column[i] + (2.0 * number - 43.0) * normal[i] for i in range(3)]
        one.put(dicom.ROWS_COLUMNS, "\\".join("%.6f" % v for v in axes))
        one.put(dicom.PLACE, "\\".join("%.4f" % v for v in first))

    return each(work)


def tilted(degrees):
    """The gantry leans: rows stay, columns turn, the table moves along the body."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return put(dicom.ROWS_COLUMNS, "1\\0\\0\\0\\%.6f\\%.6f" % (c, s))


def valued(value_of):
    """Other HU: value_of(HU, voxel of the slice, slice)."""

    def work(number, one):
        one.put_values(
            [max(-32768, min(32767, int(value_of(v - 1024, i, number)) + 1024)) for i, v in enumerate(one.values())]
        )

    return each(work)


def as_syntax(syntax, work=None):
    def change(number, one):
        one.syntax = syntax
        if work:
            work(one)

    return each(change)


def cut(index, bytes_of):
    def after(folder):
        path = os.path.join(folder, "%04d.dcm" % (index + 1))
        os.truncate(path, max(0, bytes_of(os.path.getsize(path))))

    return after


def written(name, data):
    def after(folder):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)

    return after


def flipped(seed):
    """Flips 12 bits of four files beyond the preamble."""

    def after(folder):
        lot = random.Random(seed)
        for name in lot.sample(sorted(os.listdir(folder)), 4):
            with open(os.path.join(folder, name), "r+b") as file:
                data = bytearray(file.read())
                for _ in range(12):
                    data[lot.randrange(128, 900)] ^= 1 << lot.randrange(8)
                file.seek(0)
                file.write(data)

    return after


def linked(to, name="0005.dcm"):
    def after(folder):
        path = os.path.join(folder, name)
        if os.path.lexists(path):
            os.remove(path)
        os.symlink(to, path)

    return after


def moved_away(folder):
    """The folder holds links to the files, which lie elsewhere."""
    away = folder + "_away"
    os.rename(folder, away)
    os.mkdir(folder)
    for name in os.listdir(away):
        os.symlink(os.path.join(away, name), os.path.join(folder, name))


def nested(folder):
    os.rename(folder, folder + "_in")
    os.mkdir(folder)
    os.rename(folder + "_in", os.path.join(folder, "series 1"))
