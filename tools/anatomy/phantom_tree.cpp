/* A silicone phantom of the aorto-iliac and renal region for benchmarks. Courses are plain and numbers
 * round, so that results can be checked by hand. All dimensions are this project's own choice near the
 * means of aorta_tree.cpp. */
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

VesselTree phantom_tree()
{
    const char *own = "own choice for the phantom";
    VesselTree tree{"phantom", "Aorto-renal silicone phantom", {}, 3.0, {-55, -152, 4.5}, {0, 1, 0}};
    tree.vessels = {
        {"aorta",
         {
             {{0, 160, 0}, 22.0, "aorta at the top", own},
             {{0, 100, 4}, 22.0, "", ""},
             {{0, 40, 8}, 20.0, "aorta above the renals", own},
             {{0, -20, 8}, 20.0, "aorta below the renals", own},
             {{0, -55, 4}, 20.0, "", ""},
         }},
        {"right iliac artery",
         {
             {{2, -48, 4.8}, 11.0, "", ""},
             {{-14, -72, 0}, 10.0, "right common iliac", own},
             {{-32, -98, -6}, 10.0, "", ""},
             {{-48, -124, -2}, 9.0, "right external iliac", own},
             {{-55, -150, 4}, 9.0, "", ""},
             {{-55, -170, 8}, 9.0, "", ""},
         }},
        {"left iliac artery",
         {
             {{-2, -48, 4.8}, 11.0, "", ""},
             {{14, -72, 0}, 10.0, "left common iliac", own},
             {{32, -98, -6}, 10.0, "", ""},
             {{48, -124, -2}, 9.0, "left external iliac", own},
             {{55, -150, 4}, 9.0, "", ""},
             {{55, -170, 8}, 9.0, "", ""},
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
    put_mouth(tree, -155.0);
    return tree;
}

} // namespace anatomy
