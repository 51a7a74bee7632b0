/* Computes how a quiet breath moves the soft bodies of chest and belly in a patient whose heart does not
 * beat. A smooth map takes every point from its position at the end of expiration to that at the end of
 * inspiration. Free of bones and heart, the diaphragm moves down by DOME_MM. The lungs above stretch towards
 * their apex, and the liver, the spleen and the bowel below follow by less and less. The heart on the
 * diaphragm moves as that of `anatomy heart` does (HeartBeat::inhaled). Bones, arteries, airway and kidneys
 * stay where they are, because the core's vessels do not move; the map fades out towards them.
 *
 * A dome moves by 18 +- 3 mm in a quiet breath (Boussuges 2009, Chest 135:391, lower limits 10 mm in men and
 * 9 mm in women), and by 16.6 mm per litre in the supine posture (Thorax 1994;49:885): 13 mm for 0.8 l. How
 * the motion fades is assumed. */
#pragma once
#include "tools/anatomy/mesh.hpp"
#include "tools/anatomy/person.hpp"
#include "tools/anatomy/vessels.hpp"
#include <string>
#include <vector>

namespace anatomy
{

constexpr double DOME_MM = 13.0, HEART_DOWN_MM = 8.0, HEART_FORWARD_MM = 1.5;

/* Returns true if breath moves the body with this name. */
bool breathes(const std::string &body);

/* Holds the displacement at the nodes of a lattice; between the nodes it is interpolated linearly along each
 * axis. */
class Breath
{
  public:
    Breath(const VesselTree &tree, const Person &person);
    /* Returns the position after a full breath of the tissue that is at `point` before. */
    Vec3 inhaled(const Vec3 &point) const;
    std::vector<Vec3> inhaled(const std::vector<Vec3> &points) const;
    /* Returns the smallest ratio between the volume of a cell's corner after a full breath and before. Above
     * 0, the map folds nowhere. */
    double least_volume_factor() const;

  private:
    const Vec3 &way(int x, int y, int z) const;
    void smooth(size_t step);

    std::vector<Vec3> ways_mm_; // x fastest
};

} // namespace anatomy
