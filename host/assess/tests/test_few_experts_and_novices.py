#!/usr/bin/env python3
"""Tests with two scripted experts and two scripted novices that errors, fluoroscopy, time and the path of the tip
differ between the groups. The sources are in test_experts_and_novices.py, which has 20 people in each group."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import test_experts_and_novices  # noqa: E402

if __name__ == "__main__":
    sys.exit(test_experts_and_novices.compare(2, False))
