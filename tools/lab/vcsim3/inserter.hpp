// Models the sheath that feeds the rod: the nodes inside the sheath lie on its axis and move with the hand.
#pragma once
#include "tools/lab/vcsim3/rod.hpp"

namespace vcsim3
{

class Inserter
{
  public:
    // `direction` (unit) points into the vessel.
    Inserter(const Vector &mouth_m, const Vector &direction)
        : mouth_m_(mouth_m), direction_(direction), unturned_(turn_from_z(-direction))
    {
    }
    // `axis` (unit, perpendicular to `direction`) is the segments' first axis while the hand is not turned; a
    // bent tip points in this direction.
    Inserter(const Vector &mouth_m, const Vector &direction, const Vector &axis);

    // Makes a straight rod at rest; the length `inserted_m` is outside the sheath and may be anything from 0
    // to the whole length.
    Rod make_rod(const RodProperties &properties, double inserted_m) const;

    // Places and moves the held nodes for this inserted length, and turns their segments right-handed about
    // the direction. Frees the nodes that have left the sheath.
    void feed(Rod &rod, double inserted_m, double speed_m_s, double turn_rad = 0.0) const;

    const Vector &direction() const { return direction_; }

  private:
    Vector mouth_m_, direction_;
    Quaternion unturned_; // orientation of held segments
};

} // namespace vcsim3
