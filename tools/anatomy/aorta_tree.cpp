/* Makes the shipped arterial tree, from the access at the right groin to the three branches of the arch.
 * Courses follow the skeleton of skeleton_spine.cpp (same frame: +x patient left, +y head, +z front, origin
 * between T12 and L1). Diameters are means for men. */
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

namespace
{

const char *ROGERS = "Rogers 2013, Am J Cardiol 111:1510 (Framingham CT, men)";
const char *LEE = "Lee 2013, J Korean Soc Radiol 69:105 (CT, 300 adults)";
const char *YAN = "Yan 2017 (CT angiography, 217 normal arches)";
const char *ILIAC = "Lunn-Collier 2023 (CT angiography, 224 adults)";
const char *GROIN =
    "Lunn-Collier's common iliac x ratio of upper reference values in Lorbeer 2018, PLoS ONE 13:e0197559";
const char *RENAL = "31.3 mm2 in men: renal artery cross-section study 2019, PMID 31106842";
const char *ASSUMED = "assumed";
const char *BETWEEN = "assumed: between its neighbours";

Vessel aorta()
{
    return {"aorta",
            {
                {{8, 138, 12}, 24.0, "annulus (closed valve)", ASSUMED},
                {{4, 150, 19}, 33.0, "sinuses of Valsalva", ASSUMED},
                {{-3, 166, 27}, 30.0, "sinotubular junction", ASSUMED},
                {{-10, 186, 33}, 34.1, "ascending aorta", ROGERS},
                {{-10, 206, 30}, 32.0, "", ""},
                {{-3, 221, 20}, 30.0, "arch before the branches", BETWEEN},
                {{9, 229.5, 2}, 28.5, "", ""},
                {{20, 228, -20}, 27.0, "", ""},
                {{26, 216, -39}, 26.2, "arch after the branches", BETWEEN},
                {{28, 194, -50}, 25.8, "descending thoracic aorta", ROGERS},
                {{28, 160, -55}, 25.0, "", ""},
                {{26, 120, -52}, 24.0, "", ""},
                {{21, 80, -43}, 23.0, "", ""},
                {{13, 40, -28}, 21.7, "aorta at the diaphragm", LEE},
                {{7, 10, -15.5}, 21.0, "aorta at the coeliac axis", LEE},
                {{5, -15, -7}, 20.0, "", ""},
                {{5, -35, -1.5}, 19.4, "suprarenal aorta", LEE},
                {{6, -65, 4}, 19.3, "infrarenal aorta", ROGERS},
                {{8, -100, 6}, 19.0, "", ""},
                {{8, -132, 4}, 18.7, "lower abdominal aorta", ROGERS},
                {{7, -147, 2}, 17.0, "", ""},
            }};
}

Vessel right_iliac()
{
    return {"right iliac artery",
            {
                {{6, -143, 2}, 12.0, "", ""},
                {{-6, -158, 1}, 9.7, "", ""},
                {{-18, -173, -3}, 9.5, "right common iliac", ILIAC},
                {{-28, -187, -11}, 9.5, "", ""},
                {{-36, -204, -20}, 9.2, "", ""},
                {{-43, -224, -21}, 8.5, "", ""},
                {{-54, -243, -9}, 8.3, "right external iliac", GROIN},
                {{-66, -258, 9}, 8.3, "", ""},
                {{-74, -272, 26}, 8.25, "", ""},
                {{-78, -290, 35}, 8.2, "right common femoral", GROIN},
                {{-79, -312, 37}, 8.2, "", ""},
                {{-79, -336, 36}, 8.2, "", ""},
            }};
}

Vessel left_iliac()
{
    return {"left iliac artery",
            {
                {{8, -143, 2}, 12.0, "", ""},
                {{19, -159, 2}, 9.7, "", ""},
                {{29, -174, -2}, 9.5, "left common iliac", ILIAC},
                {{37, -190, -13}, 9.5, "", ""},
                {{41, -210, -21}, 9.1, "", ""},
                {{50, -228, -16}, 8.5, "", ""},
                {{62, -243, -3}, 8.3, "left external iliac", GROIN},
                {{70, -257, 13}, 8.3, "", ""},
                {{75, -273, 28}, 8.25, "", ""},
                {{78, -291, 36}, 8.2, "left common femoral", GROIN},
                {{79, -312, 38}, 8.2, "", ""},
                {{79, -336, 37}, 8.2, "", ""},
            }};
}

/* Both ostia lie between L1 and L2, the right one slightly higher and pointing further down (Eur Radiol
 * 1999;9:1330). */
std::vector<Vessel> renals()
{
    return {{"right renal artery",
             {
                 {{5, -41, -1}, 6.3, "", ""},
                 {{-10, -45, 0}, 6.3, "", ""},
                 {{-26, -52, -9}, 6.3, "right renal", RENAL},
                 {{-42, -58, -24}, 6.0, "", ""},
                 {{-56, -60, -36}, 5.2, "", ""},
             }},
            {"left renal artery",
             {
                 {{5, -44, 0}, 6.3, "", ""},
                 {{19, -46, -3}, 6.3, "", ""},
                 {{34, -49, -15}, 6.3, "left renal", RENAL},
                 {{47, -51, -29}, 6.0, "", ""},
                 {{58, -50, -40}, 5.2, "", ""},
             }}};
}

std::vector<Vessel> arch_branches()
{
    return {{"brachiocephalic artery",
             {
                 {{-3, 218, 17}, 12.5, "", ""},
                 {{-14, 247, 16.5}, 12.5, "brachiocephalic", YAN},
                 {{-21, 258, 13}, 12.0, "", ""},
                 {{-27, 270, 9}, 10.5, "", ""},
             }},
            {"right subclavian artery",
             {
                 {{-26, 268, 9.5}, 9.0, "", ""},
                 {{-38, 281, 4}, 8.7, "right subclavian", "assumed"},
                 {{-58, 288, -6}, 8.5, "", ""},
                 {{-80, 280, -16}, 8.2, "", ""},
                 {{-100, 266, -24}, 8.0, "", ""},
                 {{-116, 256, -30}, 7.8, "", ""},
             }},
            {"right common carotid artery",
             {
                 {{-25, 267, 9.5}, 7.5, "", ""},
                 {{-25, 284, 5}, 7.0, "right common carotid", ASSUMED},
                 {{-25, 306, -3}, 6.7, "", ""},
                 {{-27, 332, -8}, 6.5, "", ""},
             }},
            {"left common carotid artery",
             {
                 {{7, 226, 5}, 8.28, "", ""},
                 {{10, 248, 4}, 8.28, "left common carotid", YAN},
                 {{17, 272, 2}, 7.6, "", ""},
                 {{23, 300, -5}, 7.0, "", ""},
                 {{27, 332, -10}, 6.6, "", ""},
             }},
            {"left subclavian artery",
             {
                 {{19, 226, -17}, 10.41, "", ""},
                 {{24, 249, -19}, 10.41, "left subclavian", YAN},
                 {{33, 272, -17}, 9.6, "", ""},
                 {{49, 286, -13}, 8.8, "", ""},
                 {{72, 284, -16}, 8.4, "", ""},
                 {{96, 268, -24}, 8.1, "", ""},
                 {{114, 256, -30}, 7.8, "", ""},
             }}};
}

/* Mean flows at rest, as rounded means of textbook values for a man of 70 kg (assumed). The arteries of
 * gut, liver and trunk are not modelled, so the aorta carries only what the modelled arteries need. */
double resting_flow_ml_min(const std::string &vessel)
{
    if (vessel.find("renal") != std::string::npos) return 550;
    if (vessel.find("carotid") != std::string::npos) return 400;
    if (vessel.find("subclavian") != std::string::npos) return 300;
    return vessel.find("iliac") != std::string::npos ? 500 : 0;
}

} // namespace

VesselTree aorta_tree()
{
    VesselTree tree{"aorta", "Aorta with iliac arteries, renals and arch branches", {}, 4.0, {}, {}};
    tree.vessels = {aorta(), right_iliac(), left_iliac()};
    for (const Vessel &vessel : renals()) tree.vessels.push_back(vessel);
    for (const Vessel &vessel : arch_branches()) tree.vessels.push_back(vessel);
    for (Vessel &vessel : tree.vessels) vessel.flow_ml_min = resting_flow_ml_min(vessel.name);
    // The entry at the introducer sheath is the sample of the right iliac curve nearest to the middle of the
    // femoral head.
    put_mouth(tree, -300.0);
    return tree;
}

} // namespace anatomy
