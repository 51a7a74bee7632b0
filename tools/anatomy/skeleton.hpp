/* Declares the bones of the shipped patient. Each group of bones is a Solid (shapes.hpp) in the patient
 * frame. */
#pragma once
#include "tools/anatomy/shapes.hpp"
#include <cstdint>
#include <string>
#include <vector>

namespace anatomy
{

enum class Sex { man, woman };
enum class Arms { raised, beside }; // over the head, or beside the body

/* How the spine of a person differs from the shipped man's: what is added to his kyphosis between T4 and T12
 * (Cobb), and the angle of a slight scoliosis, whose curve bulges to the right at the chest and to the left
 * at the loins. */
struct SpineBend {
    double kyphosis_deg = 0.0, scoliosis_deg = 0.0;
    bool operator==(const SpineBend &) const = default;
};

/* Returns how far the middle of the spine lies from the shipped man's at a height. */
Vec3 spine_shift_mm(const SpineBend &bend, double y_mm);

/* Returns how far it lies behind his where the kyphosis adds most; 0 if it lies in front. */
double deepest_shift_mm(const SpineBend &bend);

/* Moves a point of the trunk with the spine: what lies at the spine or behind it moves as the spine does,
 * what lies farther in front moves less, and the front of the chest stays. A scoliosis moves only what lies
 * near the midplane. */
Vec3 moved_with_spine(const SpineBend &bend, const Vec3 &p);

/* Returns where a point of the trunk lay before it moved, within 0.3 mm. */
Vec3 before_bend(const SpineBend &bend, const Vec3 &p);

/* States what distinguishes the bones of one person from those of another. Without changes, it states the
 * shipped man. All bones are made for a man 1.78 m tall in the shipped patient's frame; the meshes of other
 * persons are scaled afterwards. */
struct SkeletonShape {
    Sex sex = Sex::man;
    double osteophytes = 0.3;       // spurs at the edges of the vertebrae: 0 none, 1 severe
    double cartilage_calcium = 0.2; // share of the costal cartilages' length that calcium covers, 0 to 1
    Arms arms = Arms::raised;
    double age_years = 60.0; // beyond 60, the ribs slope less
    SpineBend bend = {};
    std::uint32_t sides_seed = 0; // draws how left and right differ; 0: as in the shipped man
    bool operator==(const SkeletonShape &) const = default;
};

/* Returns the shape of a person in whom osteophytes, calcium of the cartilages and kyphosis are usual for the
 * age. */
SkeletonShape usual_skeleton(Sex sex, double age_years);

/* Returns the mean Hounsfield units of the spongy bone of L1. */
double lumbar_hu(Sex sex, double age_years);
/* Returns the name of the material of spongy bone that has `density` times the Hounsfield units of L1:
 * "spongy_14" is 14 % of bone in yellow marrow. A density of 0 gives the nominal material. */
std::string spongy_material(double density, const SkeletonShape &shape);

/* How the left side of a vertebra differs from its mirror image; the right side differs by the opposite. */
struct SideDifference {
    double pedicle_wider = 0.0;                                    // in parts of the pedicle's width
    double transverse_longer_mm = 0.0, transverse_higher_mm = 0.0; // the tip of the transverse process
    double facet_turned_deg = 0.0;                                 // the joint with the vertebra above
    double spinous_left_mm = 0.0;                                  // the tip of the spinous process
};

/* Holds the position and the size of one vertebra. `up` is the direction of the spine at the centre of the
 * vertebra. */
struct Vertebra {
    std::string name;
    double height_mm, wedge_mm, width_mm, depth_mm, disc_below_mm; // wedge: front higher than back
    Vec3 centre_mm, up, front;
    SideDifference left;
};

/* Returns the vertebrae from the top down. */
std::vector<Vertebra> vertebrae(const SkeletonShape &shape = {});

/* Holds the sternum at one height: half of its width and depth, and where its middle lies. */
struct SternumSection {
    double half_width_mm, half_depth_mm, z_mm;
};
SternumSection sternum_section(double y_mm);

Solid spine_bones(const SkeletonShape &shape = {});       // C1-L5, sacrum, coccyx
Solid vertebral_discs(const SkeletonShape &shape = {});   // between T1 and L5; no bone, and no body
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
