/* A second silicone phantom: a long tortuous femoral access, the common iliac bifurcation, the aortic
 * bifurcation and the renal arteries. An instrument's shaft therefore lies in it as well as its soft end.
 * Courses are plain and numbers round; all dimensions are this project's own choice near the means of
 * aorta_tree.cpp. */
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

VesselTree access_tree()
{
    const char *own = "own choice for the phantom";
    VesselTree tree{"phantom_access", "Silicone phantom with a winding access", {}, 3.0, {}, {0, 1, 0}};
    tree.vessels = {
        {"aorta",
         {
             {{0, 160, 0}, 22.0, "aorta at the top", own},
             {{0, 100, 4}, 22.0, "", ""},
             {{0, 40, 8}, 20.0, "aorta above the renals", own},
             {{0, -20, 8}, 20.0, "aorta below the renals", own},
             {{0, -55, 4}, 20.0, "", ""},
         }},
        {"right iliac and femoral artery",
         {
             {{2, -46, 4.8}, 13.0, "", ""},
             {{-16, -72, -4}, 12.0, "right common iliac", own},
             {{-38, -96, -16}, 12.0, "", ""},
             {{-46, -118, -16}, 11.0, "right external iliac", own},
             {{-66, -138, -4}, 11.0, "", ""},
             {{-82, -158, 12}, 11.0, "", ""},
             {{-74, -182, 22}, 11.0, "", ""},
             {{-54, -200, 20}, 10.0, "", ""},
             {{-50, -224, 16}, 10.0, "", ""},
             {{-66, -244, 18}, 10.0, "right common femoral", own},
             {{-74, -268, 14}, 10.0, "", ""},
             {{-70, -294, 8}, 10.0, "", ""},
             {{-68, -316, 6}, 10.0, "", ""},
         }},
        {"right internal iliac artery",
         {
             {{-38, -96, -16}, 8.0, "", ""},
             {{-36, -112, -28}, 7.0, "", ""},
             {{-32, -134, -40}, 6.0, "right internal iliac", own},
         }},
        {"left iliac artery",
         {
             {{-2, -46, 4.8}, 13.0, "", ""},
             {{16, -72, -4}, 12.0, "left common iliac", own},
             {{38, -96, -16}, 12.0, "", ""},
             {{50, -124, -12}, 10.0, "left external iliac", own},
             {{55, -150, 4}, 9.0, "", ""},
         }},
        {"right renal artery",
         {
             {{0, 20, 8}, 6.0, "", ""},
             {{-16, 16, 8}, 6.0, "", ""},
             {{-35, 6, 2}, 6.0, "right renal", own},
             {{-60, -4, -8}, 6.0, "", ""},
         }},
        {"left renal artery",
         {
             {{0, 12, 8}, 6.0, "", ""},
             {{16, 10, 8}, 6.0, "", ""},
             {{35, 3, 2}, 6.0, "left renal", own},
             {{60, -2, -8}, 6.0, "", ""},
         }},
    };
    put_mouth(tree, -300.0);
    return tree;
}

} // namespace anatomy
