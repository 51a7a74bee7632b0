/* Skin, lungs with their vessels, heart, airway and gas of the shipped patient. All shapes are assumed, set by eye against
 * what a chest and abdomen look like under X-ray; none carries a measured dimension. */
#pragma once
#include "tools/anatomy/shapes.hpp"

namespace anatomy
{

/* Trunk from mid-thigh to the neck with raised arms' stumps. Distances are estimates of the right sign. */
Solid skin();

/* Chest cavity of one side down to the diaphragm (sign -1 right, +1 left), before anything is taken out of it. */
Distance lung_cavity(double sign);
Box lung_bounds(double sign);

/* What the lungs leave free in the middle of the chest besides bones and aorta: heart, great veins, hila, soft tissue. */
Solid mediastinum();

Solid heart_blood(); // chambers, inside the heart's outline
Solid airway();      // trachea and main bronchi (air)
Solid bowel_gas();   // stomach bubble, colon and rectum (air)
Solid kidney_fat();  // fat around the kidneys; the kidneys are cut out of it

/* Branching vessels inside one lung, whose inside is given. */
Solid lung_vessels(double sign, const Distance &lung);

} // namespace anatomy
