/* Skin, lungs with their vessels, heart, airway and gas of the shipped patient. All shapes are assumed, set
 * by eye against what a chest and abdomen look like under X-ray; none carries a measured dimension. */
#pragma once
#include "tools/anatomy/shapes.hpp"

namespace anatomy
{

/* Trunk from mid-thigh to the neck with raised arms' stumps. Distances are estimates of the right sign. */
Solid skin();

/* How deep under the skin's outside muscle begins: skin and the fat under it. */
double flesh_depth_mm(const Vec3 &p);

/* Chest cavity of one side down to the diaphragm (sign -1 right, +1 left), before anything is taken out of
 * it. */
Distance lung_cavity(double sign);
Box lung_bounds(double sign);

/* What the lungs leave free in the middle of the chest besides bones and aorta: heart, great veins, hila,
 * soft tissue. */
Solid mediastinum();

/* One chamber of the heart as a distance, clear of the chambers before it. */
struct Chamber {
    const char *name;
    Distance distance;
    Box bounds;
};

Solid heart_outline();                 // a little inside what the lungs leave free
std::vector<Chamber> heart_chambers(); // ventricles and atria, walls of 2.5 to 10 mm between them
Solid airway();                        // trachea and main bronchi (air)

/* The belly's room from the diaphragm to the pelvic floor, before chest, bones and psoas are taken out of it.
 */
double belly_outline(const Vec3 &p);
Box belly_bounds();
Solid kidney_nests(); // room for the kidneys with fat around them, beside the spine
Solid psoas();        // both, from T12 to the groin: flesh beside the belly's fat
Solid kidneys();
Solid liver();
Solid spleen();
Solid bowel_gas(double wall_mm); // stomach bubble, colon and rectum, blown up by a wall
Solid bowel(double wall_mm);     // stomach, colon, small bowel, and that wall around the gas

/* Branching vessels inside one lung, whose inside is given. */
Solid lung_vessels(double sign, const Distance &lung);

} // namespace anatomy
