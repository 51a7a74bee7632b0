// Runs the firmware core with a single instrument, using only the functions that an insertion needs. Of all
// files in this folder, only core_rod.hpp and core_rod.cpp call the core.
#pragma once
#include "shared/wire/wire.h"
#include "tools/lab/calibrate/hand.hpp"
extern "C" {
#include "firmware/core/lumen.h"
}

namespace crn::calibrate
{

class CoreRod final : public HeldRod
{
  public:
    // The object that `lumen` points to must outlive the CoreRod; if `lumen` is nullptr, the rod moves in
    // free space. Throws TrialRefused when the core rejects the instrument.
    CoreRod(const crn_wire_instrument &table, const crn_lumen *lumen, const Vector3d &mouth_mm,
            const Vector3d &direction, const Vector3d &gravity_m_s2, double inserted_mm);
    // Returns the core's version. Two simulations with equal inputs and with the same version of the core
    // have equal hashes.
    static unsigned version();
    ~CoreRod() override;

    void tick(double hand_mm, double turn_deg) override;
    double inserted_mm() const override;
    double handle_axial_mN() const override;
    bool is_sound() const override; // nothing is saturated, nothing lies outside the field
    std::vector<Vector3d> nodes_mm() const override;

  private:
    struct Core;
    std::unique_ptr<Core> core_;
};

} // namespace crn::calibrate
