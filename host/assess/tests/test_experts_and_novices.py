#!/usr/bin/env python3
"""Tests that the assessment distinguishes 20 scripted experts from 20 scripted novices. The differences must have the
direction and the order of magnitude that studies published. A measured difference must lie between a third of the
published difference and three times that difference. The residual stenosis of the two groups must not differ. The
script test_few_experts_and_novices.py runs a small sample of this test.

Crossley et al., J NeuroIntervent Surg 2019;11:775, studied thrombectomy on a simulator. Experts were 19 % faster than
novices, made 42 % fewer errors, and did 40 % more phases and 20 % more steps. In carotid stenting on a simulator (Acta
Radiol 2008), novices needed 8.7 min more fluoroscopy than experts, with similar residual stenosis. The test divides the
8.7 min by the 11.2 min of fluoroscopy that PMC7400356 reports. In Rolls et al., EuroIntervention, the tip's path in the
picture was 3,836 pixels long for experts and 10,556 pixels long for novices.
"""

import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import people  # noqa: E402


def compare(count, checks_spread):
    """Plays the sessions of both groups and prints a TAP line for each claim."""
    results = []

    def claim(name, is_true, text):
        results.append(is_true)
        print(f"# {text}")
        print(("ok" if is_true else "not ok"), len(results), "-", name, flush=True)

    with tempfile.TemporaryDirectory(prefix="cournand_people_") as folder:
        scene = people.write_scene(folder)
        experts = people.group(folder, scene, "expert", range(1, count + 1))
        novices = people.group(folder, scene, "novice", range(1, count + 1))

    def ratio(name, published):
        found = people.median_ratio(novices, experts, name)
        low, high = 1 + (published - 1) / 3, 1 + (published - 1) * 3
        claim(
            f"novices_have_more_{name}_than_experts",
            low <= found <= high,
            f"{name}: {found:.2f} times, published {published:.2f}, allowed {low:.2f} to {high:.2f}",
        )

    separation = people.auc(novices["errors"], experts["errors"])
    ratio("time_s", 1 / 0.81)
    ratio("errors", 1 / 0.58)
    ratio("fluoroscopy_s", 1 + 8.7 / 11.2)
    ratio("path_px", 10556 / 3836)
    claim(
        "errors_separate_the_groups", separation >= 0.9, f"AUC by the number of errors {separation:.3f}, at least 0.9"
    )
    if checks_spread:
        smooth = people.auc(novices["submovements"], experts["submovements"])
        claim("submovements_separate_the_groups", smooth >= 0.9, f"AUC by submovements {smooth:.3f}, at least 0.9")
        score = people.auc(experts["percent"], novices["percent"])
        claim("the_score_separates_the_groups", score >= 0.9, f"AUC by the score {score:.3f}, at least 0.9")
        p = people.mann_whitney_p(novices["stenosis_pct"], experts["stenosis_pct"])
        area = people.auc(novices["stenosis_pct"], experts["stenosis_pct"])
        claim(
            "residual_stenosis_does_not_separate_the_groups",
            p > 0.05 and 0.25 < area < 0.75,
            f"residual stenosis: AUC {area:.2f}, allowed 0.25 to 0.75; Mann-Whitney p {p:.2f}, at least 0.05",
        )
    print(f"1..{len(results)}")
    for name in experts:
        print(f"# {name}: experts {experts[name]}, novices {novices[name]}")
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(compare(20, True))
