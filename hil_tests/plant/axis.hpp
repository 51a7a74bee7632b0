// Simulates one axis of a track (translation or rotation): a hand moves the tool, a grip that may slip
// connects the tool to a roller, and the motor acts on the roller.
//
//      hand (prescribed, spring and damper, or none)
//        | force
//      tool, inertia m_t, speed v ----- grip: transmits at most `grip_limit` -----+
//                                                                                 |
//      motor force, first-order lag ----> roller, inertia m_r, speed w: Coulomb and viscous friction, encoder
//
// Positions are in m or rad and positive into the patient; forces are in N or N m. A positive motor command
// pushes the hand back out of the patient, so it accelerates the tool in the negative direction. In every
// time step (of 50 us, unless the settings state another), the frictions of the grip and of the bearing are
// computed together, as two impulses with limits. A body at rest therefore stays exactly at rest while the
// force on it is below its friction.
#pragma once

namespace hil
{

struct AxisSettings {
    double tool_inertia = 0.02;    // kg: the part of tool and hand that moves with it
    double roller_inertia = 0.01;  // kg: roller and motor, reflected to the tool
    double coulomb = 0.05;         // N, bearing of the roller
    double viscous = 1.0;          // N s/m
    double grip_limit = 12.0;      // N; beyond it the tool slips on the roller
    double motor_limit = 10.0;     // N, set by the limit of its current
    double motor_lag_s = 0.0015;   // of the current
    double motor_decay_s = 0.0003; // of the current when the power stage is off
    double hand_stiffness = 600.0; // N/m
    double hand_damping = 6.0;     // N s/m
    // Change of the frictions' impulses, as a share of the bearing's limit, at which their computation ends;
    // 0: only when nothing changes any more. Runs of hours state a share, because the last bits may take 200
    // sweeps.
    double sweep_tolerance = 0.0;
    int steps_per_ms = 20;
};

// Holds the settings for the rotation about the tool's axis, in kg m^2, N m, N m s and rad.
inline constexpr AxisSettings rotation_axis_settings{2e-7,  2e-7,   2e-4,   2e-6, 0.05,
                                                     0.025, 0.0015, 0.0003, 0.02, 1e-4};

enum class Hand {
    prescribed, // the tool is where the hand is
    spring,     // the hand's place is prescribed, and a spring connects the tool
    none,       // nobody holds the tool
};

enum class MotorFault {
    none,
    stuck_on, // the driver gives its limit whatever the command, as long as it has power
    dead,     // no current
};

class Axis
{
  public:
    explicit Axis(const AxisSettings &settings) : settings_(settings) {}

    // Runs one millisecond. `command` is the force in N that the device commands the motor to exert;
    // `powered` states whether the power stage is on.
    void step(double command, bool powered);

    void set_hand(Hand hand) { hand_ = hand; }
    void move_hand(double speed) { hand_speed_ = speed; } // from now on
    void set_motor_fault(MotorFault fault) { motor_fault_ = fault; }
    void set_motor_limit(double limit) { settings_.motor_limit = limit; } // of the driver's current

    double roller() const { return roller_; } // the encoder turns with it
    double tool() const { return tool_; }
    double tool_speed() const { return tool_speed_; }
    double hand() const { return hand_place_; }
    double motor_force() const { return motor_force_; } // present value, + pushes the hand out
    double motor_peak() const { return motor_peak_; }   // largest size within the last millisecond
    double force_on_hand() const
    {
        return hand_force_;
    } // mean of the last millisecond, + pushes the hand out
    bool is_slipping() const { return is_slipping_; }
    bool is_limited() const { return is_limited_; } // the driver cannot give the commanded force
    const AxisSettings &settings() const { return settings_; }

  private:
    void advance(double command, bool powered, double step_s);
    void solve(double tool_free, double tool_mobility, double roller_free, double step_s);

    AxisSettings settings_;
    Hand hand_ = Hand::prescribed;
    MotorFault motor_fault_ = MotorFault::none;
    double hand_place_ = 0.0, hand_speed_ = 0.0;
    double tool_ = 0.0, tool_speed_ = 0.0;
    double roller_ = 0.0, roller_speed_ = 0.0;
    double motor_force_ = 0.0, motor_peak_ = 0.0, hand_force_ = 0.0;
    double grip_impulse_ = 0.0;
    double decay_ = 0.0, decay_lag_s_ = 0.0; // what the lag leaves of a difference in one time step
    bool is_slipping_ = false, is_limited_ = false;
};

} // namespace hil
