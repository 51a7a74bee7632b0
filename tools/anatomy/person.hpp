/* States what distinguishes one person from another: sex, age, size, weight. The shapes of bones and soft
 * bodies follow from it. Without changes, it states the shipped man. */
#pragma once
#include "tools/anatomy/skeleton.hpp"
#include <cstdint>

namespace anatomy
{

/* All bodies are made in the frame of a man of this height, and are then scaled about the frame's origin. */
constexpr double SHIPPED_HEIGHT_M = 1.78, SHIPPED_BMI = 24.0;

/* How the soft bodies differ from those of the shipped man, in the shipped frame. */
struct SoftShape {
    Sex sex = Sex::man;
    double fat = 1.0;       // thickness of the fat under the skin, in parts of the shipped man's
    double belly_mm = 0.0;  // the wall of the belly lies so much farther out, because of the fat behind it
    double breast_mm = 0.0; // radius of a breast; 0: none
    double gas = 1.0;       // size of the pouches of gas in the bowel, in parts of the shipped man's
    std::uint32_t bowel_seed = 0; // other pouches; 0: the shipped man's
    double wall_calcium = 0.0;    // plaques on the aorta and the iliac arteries: 0 none, 1 many
    std::uint32_t calcium_seed = 1;
    Arms arms = Arms::raised;
    SpineBend bend = {}; // the back follows the spine
};

/* What lies on or in the patient on request (clutter.hpp). */
struct Clutter {
    bool leads = false, table = false, wires = false, pacemaker = false;
};

struct Person {
    Sex sex = Sex::man;
    double age_years = 60.0, height_m = SHIPPED_HEIGHT_M;
    double weight_kg = SHIPPED_BMI * SHIPPED_HEIGHT_M * SHIPPED_HEIGHT_M;
    double osteophytes = 0.3, cartilage_calcium = 0.2; // SkeletonShape
    double wall_calcium = 0.25;                        // SoftShape
    double gas = 1.0;
    SpineBend bend = {};
    Arms arms = Arms::raised;
    Clutter clutter;
    std::uint32_t seed =
        0; // of bowel gas, plaques, and what differs between left and right; 0: the shipped man

    double bmi() const { return weight_kg / (height_m * height_m); }
    double scale() const { return height_m / SHIPPED_HEIGHT_M; }
};

/* Returns the shape of the bones in the shipped frame. */
SkeletonShape skeleton_shape(const Person &person);
SoftShape soft_shape(const Person &person);

} // namespace anatomy
