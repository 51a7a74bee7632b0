/* Assembles an anatomy: lumen, centrelines and the bodies of the X-ray picture, each a closed mesh. */
#pragma once
#include "tools/anatomy/mesh.hpp"
#include "tools/anatomy/vessels.hpp"
#include <functional>
#include <string>
#include <vector>

namespace anatomy
{

/* One body of the X-ray picture. It lies completely inside the body named by `inside` ("" for the
 * outermost). */
struct Body {
    std::string name, material, inside;
    MeshRequest request;
};

struct Fineness {
    double lumen_voxel_mm = 0.8;
    double body_scale = 1.0; // multiplies the voxel of every body
};

MeshRequest lumen_request(const VesselTree &tree, const Fineness &fineness);
std::vector<Body> patient_bodies(const Fineness &fineness);
std::vector<Body> heart_patient_bodies(const Fineness &fineness); // with the vessels of the heart
std::vector<Body> phantom_bodies(const Fineness &fineness);

} // namespace anatomy
