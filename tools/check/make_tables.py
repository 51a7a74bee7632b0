#!/usr/bin/env python3
"""Generates firmware/core/fixed_tables.c, which holds the constants that firmware/core/fixed.h uses.

  make_tables.py            write the file
  make_tables.py --check    fail when the committed file differs from what this program writes

To approximate a convex function by a straight line, the script takes the chord on each interval and lowers it by half
of its largest distance to the curve. Of all straight lines, the lowered chord has the smallest maximum error on the
interval. One Newton step in fixed.h doubles the number of correct bits that the straight line of this table gives. To
approximate asin(x)/x by a polynomial, the script interpolates at the Chebyshev points of the interval. The largest
error of this interpolation is at most about twice that of the best polynomial of the same degree.
"""

import math
import os
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
TARGET = os.path.join(ROOT, "firmware", "core", "fixed_tables.c")
Q30 = 1 << 30


def line(function, derivative_inverse, low, high):
    """Returns two Q30 integers of the best straight line: its value at `low`, and its drop over [low, high]."""
    slope = (function(high) - function(low)) / (high - low)
    touch = derivative_inverse(slope)
    gap = function(low) + slope * (touch - low) - function(touch)
    return round((function(low) - gap / 2) * Q30), round(-slope * (high - low) * Q30)


def reciprocal_rows():
    """Returns straight lines that approximate 1/x on [1/2, 1), one for each of 128 intervals."""
    for i in range(128, 256):
        yield line(lambda x: 1 / x, lambda s: math.sqrt(-1 / s), i / 256, (i + 1) / 256)


def rsqrt_rows():
    """Returns straight lines that approximate x^(-1/2), whose derivative is -x^(-3/2)/2, on [1/4, 1), one for each of
    192 intervals."""
    for i in range(64, 256):
        yield line(lambda x: 1 / math.sqrt(x), lambda s: (-2 * s) ** (-2 / 3), i / 256, (i + 1) / 256)


def solve(matrix, right):
    """Solves the 7 x 7 linear equations of the polynomial interpolation by Gaussian elimination with pivoting."""
    size = len(right)
    rows = [list(matrix[i]) + [right[i]] for i in range(size)]
    for k in range(size):
        pivot = max(range(k, size), key=lambda r: abs(rows[r][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for r in range(k + 1, size):
            factor = rows[r][k] / rows[k][k]
            rows[r] = [a - factor * b for a, b in zip(rows[r], rows[k])]
    answer = [0.0] * size
    for k in reversed(range(size)):
        answer[k] = (rows[k][size] - sum(rows[k][j] * answer[j] for j in range(k + 1, size))) / rows[k][k]
    return answer


def asin_coefficients():
    """Returns the coefficients of asin(x)/x = 1 + z (c0 + c1 z + ... + c6 z^6) with z = x^2 in [0, 1/4], as Q31
    integers."""
    count = 7
    points = [0.125 + 0.125 * math.cos(math.pi * (i + 0.5) / count) for i in range(count)]
    target = [(math.asin(math.sqrt(z)) / math.sqrt(z) - 1) / z for z in points]
    return [round(c * 2**31) for c in solve([[z**j for j in range(count)] for z in points], target)]


def table(text, name, rows):
    text.append("const crn_line_q30 %s[%d] = {" % (name, len(rows)))
    for i in range(0, len(rows), 4):
        text.append("    " + " ".join("{%du, %du}," % row for row in rows[i : i + 4]))
    text.append("};")
    text.append("")


def generate():
    text = [
        "/* Constants of firmware/core/fixed.h. tools/check/make_tables.py writes this file: change that script, not",
        " * this file. */",
        '#include "firmware/core/fixed.h"',
        "",
        "// clang-format off",
        "/* 1/x on [1/2, 1), 128 intervals: relative error <= 2^-17. */",
    ]
    table(text, "crn_reciprocal_lines", list(reciprocal_rows()))
    text.append("/* x^(-1/2) on [1/4, 1), 192 intervals: relative error <= 2^-16.4. */")
    table(text, "crn_rsqrt_lines", list(rsqrt_rows()))
    coefficients = asin_coefficients()
    text.append("/* asin(x)/x = 1 + z (c0 + c1 z + ... + c6 z^6), z = x^2 in [0, 1/4], Q31. */")
    text.append("const int32_t crn_asin_coefficients_q31[%d] = {" % len(coefficients))
    text.append("    " + ", ".join(str(c) for c in coefficients) + ",")
    text.append("};")
    text.append("// clang-format on")
    return "\n".join(text) + "\n"


def main():
    if sys.argv[1:] == ["--check"]:
        with open(TARGET, encoding="ascii") as file:
            if file.read() == generate():
                return 0
        print("firmware/core/fixed_tables.c differs from tools/check/make_tables.py: run that program and commit")
        return 1
    if sys.argv[1:]:
        print(__doc__)
        return 2
    with open(TARGET, "w", encoding="ascii") as file:
        file.write(generate())
    return 0


if __name__ == "__main__":
    sys.exit(main())
