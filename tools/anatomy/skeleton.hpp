/* Declares the bones of the shipped patient. Each group of bones is a Solid (shapes.hpp) in the patient
 * frame. */
#pragma once
#include "tools/anatomy/shapes.hpp"
#include <string>
#include <vector>

namespace anatomy
{

enum class Sex { man, woman };
enum class Arms { raised, beside }; // over the head, or beside the body

/* States what distinguishes the bones of one person from those of another. Without changes, it states the
 * shipped man. All bones are made for a man 1.78 m tall in the shipped patient's frame; the meshes of other
 * persons are scaled afterwards. */
struct SkeletonShape {
    Sex sex = Sex::man;
    double osteophytes = 0.3;       // spurs at the edges of the vertebrae: 0 none, 1 severe
    double cartilage_calcium = 0.2; // share of the costal cartilages' length that calcium covers, 0 to 1
    Arms arms = Arms::raised;
    double age_years = 60.0; // beyond 60, the ribs slope less
    bool operator==(const SkeletonShape &) const = default;
};

/* Returns the shape of a person in whom osteophytes and calcium of the cartilages are usual for the age. */
SkeletonShape usual_skeleton(Sex sex, double age_years);

/* Holds the position and the size of one vertebra. `up` is the direction of the spine at the centre of the
 * vertebra. */
struct Vertebra {
    std::string name;
    double height_mm, width_mm, depth_mm, disc_below_mm;
    Vec3 centre_mm, up, front;
};

/* Returns the vertebrae from the top down. */
std::vector<Vertebra> vertebrae(const SkeletonShape &shape = {});

/* Holds the sternum at one height: half of its width and depth, and where its middle lies. */
struct SternumSection {
    double half_width_mm, half_depth_mm, z_mm;
};
SternumSection sternum_section(double y_mm);

Solid spine_bones(const SkeletonShape &shape = {});       // C1-L5, sacrum, coccyx
Solid rib_bones(const SkeletonShape &shape = {});         // twelve pairs, sternum
Solid costal_cartilages(const SkeletonShape &shape = {}); // of the first ten pairs
Solid cartilage_calcium(const SkeletonShape &shape = {}); // inside the cartilages; may be empty
Solid pelvis_bones(const SkeletonShape &shape = {});      // both hip bones
Solid femur_bones(const SkeletonShape &shape = {});       // upper thirds
/* Clavicles, shoulder blades, humerus. */
Solid shoulder_bones(const SkeletonShape &shape = {});
Solid head_bones();                                   // skull, jaw, teeth
Solid forearm_bones(const SkeletonShape &shape = {}); // ulna, radius, hand

} // namespace anatomy
