/* Assembles an anatomy from its lumen, its centrelines and the bodies of the X-ray picture. The lumen and the
 * bodies are closed triangle meshes. */
#pragma once
#include "tools/anatomy/mesh.hpp"
#include "tools/anatomy/person.hpp"
#include "tools/anatomy/vessels.hpp"
#include <functional>
#include <string>
#include <vector>

namespace anatomy
{

/* Describes one body (such as a bone or an organ) that X-ray pictures show. `inside` is the name of the other
 * body that completely encloses this body. For the outermost body, which nothing encloses, `inside` is "". */
struct Body {
    std::string name, material, inside;
    MeshRequest request;
    bool is_breathing = false; // a file NAME_inhaled.ply states it after a full breath (breath.hpp)
};

struct Fineness {
    double lumen_voxel_mm = 0.8;
    double body_scale = 1.0; // multiplies the voxel of every body
};

/* The lumen of the tree's vessels, and of `small` arteries that belong to it, too. */
MeshRequest lumen_request(const VesselTree &tree, const Fineness &fineness,
                          const std::vector<Curve> &small = {});

/* Returns the bodies of a person around the vessels in `tree`, whose coordinates must be in the patient's
 * frame. The bodies are not scaled by the person's size. If the tree has coronary arteries, the patient's
 * bodies include the root of the aorta and the coronary arteries. */
std::vector<Body> patient_bodies(const VesselTree &tree, const Fineness &fineness, const Person &person = {});

/* Returns the bodies of a phantom, which is a tank of water with a silicone wall around the vessels. In a
 * phantom a blood-like fluid fills the vessels. */
std::vector<Body> phantom_bodies(const VesselTree &tree, const Fineness &fineness);

} // namespace anatomy
