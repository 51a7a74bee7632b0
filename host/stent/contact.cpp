#include "host/stent/contact.hpp"
#include <ccd/ccd.h>

namespace crn
{

namespace
{

using Eigen::Vector3d;

// Positions of the strut and the tissue are relative to the middle of the strut, because doubles are most
// precise near 0.
struct Capsule {
    Vector3d half;
    double radius;
};
struct Prism {
    std::array<Vector3d, 3> corners;
    Vector3d back;
};

Vector3d from_ccd(const ccd_vec3_t *v)
{
    return {v->v[0], v->v[1], v->v[2]};
}

void capsule_support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const auto *capsule = static_cast<const Capsule *>(object);
    const Vector3d d = from_ccd(direction);
    const double length = d.norm();
    Vector3d p = d.dot(capsule->half) >= 0 ? capsule->half : Vector3d(-capsule->half);
    if (length > 0) p += d * (capsule->radius / length);
    ccdVec3Set(out, p.x(), p.y(), p.z());
}

void prism_support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const auto *prism = static_cast<const Prism *>(object);
    const Vector3d d = from_ccd(direction);
    std::size_t best = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (d.dot(prism->corners[k]) > d.dot(prism->corners[best])) best = k;
    Vector3d p = prism->corners[best];
    if (d.dot(prism->back) > 0) p += prism->back;
    ccdVec3Set(out, p.x(), p.y(), p.z());
}

void capsule_centre(const void *, ccd_vec3_t *out)
{
    ccdVec3Set(out, 0, 0, 0);
}

void prism_centre(const void *object, ccd_vec3_t *out)
{
    const auto *prism = static_cast<const Prism *>(object);
    const Vector3d p = (prism->corners[0] + prism->corners[1] + prism->corners[2]) / 3 + prism->back / 2;
    ccdVec3Set(out, p.x(), p.y(), p.z());
}

} // namespace

StrutContact strut_contact(const StrutCapsule &strut, const std::array<Vector3d, 3> &corners_mm,
                           const Vector3d &outward)
{
    const Vector3d middle = (strut.from_mm + strut.to_mm) / 2;
    const Capsule capsule{(strut.to_mm - strut.from_mm) / 2, strut.radius_mm};
    const Prism prism{{corners_mm[0] - middle, corners_mm[1] - middle, corners_mm[2] - middle},
                      outward * tissue_depth_mm};
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = capsule_support;
    ccd.support2 = prism_support;
    ccd.center1 = capsule_centre;
    ccd.center2 = prism_centre;
    ccd.max_iterations = 100;
    ccd.epa_tolerance = 1e-4;
    ccd.mpr_tolerance = 1e-5;
    ccd_real_t depth = 0;
    ccd_vec3_t direction, position;
    StrutContact contact{0.0, -outward};
    if (ccdGJKPenetration(&capsule, &prism, &ccd, &depth, &direction, &position) != 0) return contact;
    contact.depth_mm = depth;
    // libccd returns the displacement of the second body, so the strut (the first body) must move in the
    // opposite direction. If the contact pushed a strut out through a side of a small triangle, the strut
    // would meet the next triangle, for which another contact is computed.
    const Vector3d way = -from_ccd(&direction);
    if (-way.dot(outward) > 0.5) {
        contact.direction = way;
    } else {
        const double deepest = std::max(outward.dot(capsule.half), -outward.dot(capsule.half)) -
                               outward.dot(prism.corners[0]) + capsule.radius;
        contact.depth_mm = std::min(deepest, depth / 0.5);
    }
    return contact;
}

} // namespace crn
