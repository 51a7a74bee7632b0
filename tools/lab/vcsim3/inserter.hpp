// The sheath that feeds the rod: nodes beyond its mouth lie on its axis and move with the hand.
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
    // With the segments' first axis at `axis` (unit, across `direction`) while the hand is not turned: where
    // a bent tip points.
    Inserter(const Vector &mouth_m, const Vector &direction, const Vector &axis);

    // A straight rod at rest with `inserted_m` of it outside, 0 .. its length.
    Rod make_rod(const RodProperties &properties, double inserted_m) const;

    // Places and moves the held nodes for this inserted length and turns their segments, right-handed about
    // the direction; frees those that have left the mouth.
    void feed(Rod &rod, double inserted_m, double speed_m_s, double turn_rad = 0.0) const;

    const Vector &direction() const { return direction_; }

  private:
    Vector mouth_m_, direction_;
    Quaternion unturned_; // of held segments
};

} // namespace vcsim3
