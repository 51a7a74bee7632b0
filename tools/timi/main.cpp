// The program `timi` prints the frame counts of the shipped heart, and how they depend on injection,
// heartbeat and flow (docs/contrast.md).
#include "tools/anatomy/small/stated.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include "tools/timi/flow_tree.hpp"
#include "tools/timi/strahler.hpp"
#include "tools/timi/timi.hpp"
#include <cstdio>
#include <exception>

int main()
{
    using namespace anatomy;
    constexpr int LOWEST_ORDER = 7; // vessels of 0.3 mm (Kassab 1993)
    try {
        VesselTree heart = shipped_vessels("heart");
        add_stated_branches(heart);
        const crn::VesselTree tree = flow_tree(heart);
        std::printf("%zu branches of the lumen, %zu small vessels\n", tree.branches.size(),
                    tree.small.size());
        std::printf("%-6s%14s%10s%10s%10s%10s%12s%10s%10s%10s%10s\n", "artery", "published", "frames",
                    "slower", "faster", "100/min", "hyperaemia", "phase 0", "1/4", "1/2", "3/4");
        for (const TimiArtery &artery : timi_arteries()) {
            std::printf("%-6s%7.1f +-%4.1f", artery.name.c_str(), artery.mean, artery.deviation);
            for (const TimiCase &one :
                 {TimiCase{}, TimiCase{.speed = 0.7}, TimiCase{.speed = 1.4}, TimiCase{.rate_per_min = 100}})
                std::printf("%10.1f", timi_mean_frames(tree, artery, one));
            std::printf("%12.1f", timi_mean_frames(tree, artery, {.flow = 3.0}));
            for (const double share : {0.0, 0.25, 0.5, 0.75})
                std::printf("%10.1f", timi_frames(tree, artery, {.start_share = share}));
            std::printf("\n");
        }
        std::printf("coronary sinus fills %.2f s after the left main artery (published 4.16 +- 0.72)\n",
                    coronary_sinus_s(tree));
        for (const char *branch : {"LAD", "LCX", "RCA"}) {
            std::printf("%s, orders of Strahler\n%8s%10s%13s%11s\n", branch, "order", "elements",
                        "diameter_mm", "length_mm");
            for (const StrahlerOrder &one : strahler_orders(tree, branch, LOWEST_ORDER))
                std::printf("%8d%10zu%13.2f%11.1f\n", one.order, one.elements, one.diameter_mm,
                            one.length_mm);
        }
    } catch (const std::exception &error) {
        std::fprintf(stderr, "timi: %s\n", error.what());
        return 1;
    }
    return 0;
}
