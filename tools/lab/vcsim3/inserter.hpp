// Models the introducer sheath: the rod's nodes inside the sheath lie on the sheath's axis and move with the
// hand.
#pragma once
#include "tools/lab/vcsim3/rod.hpp"

namespace vcsim3
{

class Inserter
{
  public:
    // The unit vector `direction` points along the sheath into the vessel.
    Inserter(const Vector &mouth_m, const Vector &direction)
        : mouth_m_(mouth_m), direction_(direction), unturned_(turn_from_z(-direction))
    {
    }
    // The unit vector `axis`, perpendicular to `direction`, is the first axis of the segments at hand angle
    // 0; a bent tip points this way.
    Inserter(const Vector &mouth_m, const Vector &direction, const Vector &axis);

    // Makes a straight rod at rest; the length `inserted_m`, from 0 to the whole length, is outside the
    // sheath.
    Rod make_rod(const RodProperties &properties, double inserted_m) const;

    // Sets the positions and velocities of the nodes in the sheath for the given inserted length, and turns
    // their segments right-handed about `direction`. Nodes that have left the sheath become free.
    void feed(Rod &rod, double inserted_m, double speed_m_s, double turn_rad = 0.0) const;

    const Vector &direction() const { return direction_; }

  private:
    Vector mouth_m_, direction_;
    Quaternion unturned_; // orientation of held segments
};

} // namespace vcsim3
