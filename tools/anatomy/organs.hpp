/* Skin, lungs with their vessels, heart, airway and gas of the shipped patient. All shapes are assumed:
 * they are set by eye to resemble a chest and abdomen under X-ray, and none carries a measured dimension. */
#pragma once
#include "tools/anatomy/shapes.hpp"

namespace anatomy
{

/* Returns the trunk from mid-thigh to the neck, with the stumps of the raised arms. Distances are estimates
 * of the right sign. */
Solid skin();

/* Returns the depth below the outside of the skin at which muscle begins: skin and the fat under it. */
double flesh_depth_mm(const Vec3 &p);

/* The chest cavity of one side down to the diaphragm (sign -1 right, +1 left), before other bodies are cut
 * out of it. */
Distance lung_cavity(double sign);
Box lung_bounds(double sign);

/* Returns the part of the middle of the chest that the lungs leave free, besides bones and aorta: heart,
 * great veins, hila, soft tissue. */
Solid mediastinum();

/* One chamber of the heart as a distance, clear of the chambers before it. */
struct Chamber {
    const char *name;
    Distance distance;
    Box bounds;
};

Solid heart_outline();                 // slightly inside what the lungs leave free
std::vector<Chamber> heart_chambers(); // ventricles and atria, with walls of 2.5 to 10 mm between them
Solid airway();                        // trachea and main bronchi (air)

/* The belly's cavity from the diaphragm to the pelvic floor, before chest, bones and psoas are cut out of
 * it. */
double belly_outline(const Vec3 &p);
Box belly_bounds();
Solid kidney_nests(); // space for the kidneys and the fat around them, beside the spine
Solid psoas();        // both muscles, from T12 to the groin, beside the belly's fat
Solid kidneys();
Solid liver();
Solid spleen();
Solid bowel_gas(double wall_mm); // gas of stomach bubble, colon and rectum, expanded by the wall
Solid bowel(double wall_mm);     // stomach, colon, small bowel, and that wall around the gas

/* Branching vessels inside one lung; `lung` is the inside of that lung. */
Solid lung_vessels(double sign, const Distance &lung);

} // namespace anatomy
