/* Declares the shapes of the shipped patient's skin, lungs, heart, airway and bowel gas.
 * All shapes are assumed. The shapes of the organs are adjusted by eye to resemble a chest and abdomen under
 * X-ray; none of their dimensions is measured. */
#pragma once
#include "tools/anatomy/person.hpp"

namespace anatomy
{

/* Returns the shape of the body from mid-thigh to the vertex, with raised arms. The returned distances are
   estimates, but their sign (inside or outside) is right. */
Solid skin(const SoftShape &shape = {});

/* Returns the combined thickness of the skin and of the fat under the skin at a point. */
double flesh_depth_mm(const SoftShape &shape, const Vec3 &p);

/* Returns how much farther out than the shipped man's the wall of the belly lies at a point. */
double belly_growth_mm(const SoftShape &shape, const Vec3 &p);

Solid breast_glands(const SoftShape &shape); // empty for a man

/* Returns the shape of the chest cavity on one side of the body (sign -1 for right, +1 for left), down to the
 * diaphragm. The returned chest cavity still includes the space of other bodies, such as the heart, which
 * must be cut out later. */
Distance lung_cavity(double sign, const SpineBend &bend = {});
Box lung_bounds(double sign, const SpineBend &bend = {});

/* Returns the shape of the space in the middle of the chest that the heart, the great veins, the hila and
 * soft tissue fill. The lungs do not extend into the middle space of the chest. */
Solid mediastinum(const SpineBend &bend = {});

/* Describes one chamber of the heart by its distance function. A chamber of the heart keeps a distance of at
 * least a heart wall's thickness from the chambers that precede it in the list. */
struct Chamber {
    const char *name;
    Distance distance;
    Box bounds;
};

Solid heart_outline();                 // slightly inside what the lungs leave free
std::vector<Chamber> heart_chambers(); // ventricles and atria, with walls of 2.5 to 10 mm between them
Solid airway();                        // trachea and main bronchi (air)

/* Returns the distance to the belly's cavity, which reaches from the diaphragm to the pelvic floor. The
 * belly's cavity still includes the space of the chest, bones and psoas muscles, which must be cut out later.
 */
double belly_outline(const SoftShape &shape, const Vec3 &p);
Box belly_bounds(const SoftShape &shape);
Solid kidney_nests(); // space for the kidneys and the fat around them, beside the spine
Solid psoas();        // both muscles, from T12 to the groin, beside the belly's fat
Solid kidneys();
Solid liver();
Solid spleen();
Solid bladder(const SoftShape &shape); // with its urine
/* Gas of stomach bubble, colon and rectum, expanded by the wall. */
Solid bowel_gas(const SoftShape &shape, double wall_mm);
Solid faeces_gas(const SoftShape &shape);            // bubbles in the faeces of the colon
Solid bowel(const SoftShape &shape, double wall_mm); // stomach, colon, small bowel, that wall around the gas

} // namespace anatomy
