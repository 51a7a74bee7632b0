// Tests contact with walls: friction round a bend, on an incline and along a floor, and a compressed rod that
// coils in its tube.
#include "host/base/number_text.hpp"
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/support.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

namespace
{

constexpr double wire_radius_m = 445e-6;

// --- capstan ---

struct Capstan {
    double mean, low, high; // pull at the hand divided by the load at the tip
};

// A wire lies along the inner wall of a bend; a load at its tip pulls towards the tube's far end. The hand
// draws the wire back by 30 mm. The introducer is also placed at the inner wall, so that the wire turns by
// exactly the angle of the bend.
Capstan draw(double angle_rad, double friction, double tip_N)
{
    const double bend_m = 0.1, tube_m = 0.002, lead_m = 0.03, out_m = 0.07, off_m = tube_m - wire_radius_m;
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.03 + lead_m).bend(bend_m, angle_rad).straight(out_m + 0.03);
    LumenField field = tube_field(path, tube_m, 1);
    double length = lead_m + (bend_m - off_m) * angle_rad + out_m;
    Knot knot{.bend_N_m2 = 1e-5, .twist_N_m2 = 1e-5 / 1.3, .friction = friction};
    Rig rig({uniform_tool(knot, length + 0.03, 0.003)}, &field,
            {.inserted_m = {length}, .mouth_m = {0, 0, off_m}});
    Path inner({0, 0, off_m}, {1, 0, 0}, {0, 0, 1});
    inner.straight(lead_m).bend(bend_m - off_m, angle_rad).straight(1);
    std::vector<Vector3d> nodes;
    for (unsigned i = 0; i < rig.free_count(); i++) nodes.push_back(inner.at(rig.inserted() - rig.arc(i)));
    rig.place(nodes);
    rig.set_tip_load(tip_N * inner.end_direction());
    rig.step(1000);
    const double speed_m = 1e-5;
    const int ticks = 3000;
    Capstan result{0, INFINITY, -INFINITY};
    for (int tick = 1; tick <= ticks; tick++) {
        rig.feed(-tick * speed_m);
        rig.step();
        if (tick <= ticks * 2 / 3) continue;
        double ratio = -rig.handle_axial() / tip_N;
        result.mean += ratio / (ticks - ticks * 2 / 3);
        result.low = std::min(result.low, ratio);
        result.high = std::max(result.high, ratio);
    }
    return result;
}

void capstan(Result &result, bool quick)
{
    result.title = "Capstan: pull through a bend";
    result.setup = "EI 1e-5 N m2, elements of 3 mm along the inner wall of a tube of 2 mm bent with R 100 "
                   "mm; 0.5 N at the tip along "
                   "the way out; drawn back at 10 mm/s, mean over the last 10 mm (ripple: the hand's force "
                   "swings while elements "
                   "round the bend).";
    result.formula = "hand / tip = e^(mu angle)";
    result.source = "Euler, Eytelwein";
    Plot plot{"Pull through a bend", "friction coefficient", "hand / tip", {}};
    for (int bend : {90, 180}) {
        int colour = bend / 90 - 1;
        Series ours{std::to_string(bend) + " degrees", {}, {}, true, colour},
            line{"e^(mu angle)", {}, {}, false, colour};
        for (double mu : {0.0, 0.1, 0.2, 0.3, 0.4}) {
            if (quick && (bend == 180 || mu != 0.2)) continue;
            Capstan got = draw(bend * degree, mu, 0.5);
            std::string name = std::to_string(bend) + "_deg.mu_" + number_text(mu);
            result.relative(name, "", std::exp(mu * bend * degree), got.mean, 3);
            if (mu == 0.4) result.reported("ripple." + name, "", got.mean, got.high);
            ours.x.push_back(mu);
            ours.y.push_back(got.mean);
        }
        for (double mu = 0; mu < 0.41; mu += 0.01) {
            line.x.push_back(mu);
            line.y.push_back(std::exp(mu * bend * degree));
        }
        plot.series.push_back(ours);
        plot.series.push_back(line);
    }
    result.plots.push_back(plot);
}

// --- incline ---

struct Slope {
    Series travel; // angle in degrees -> mm
    double onset_deg = 0;
};

// A heavy part of a wire, 250 mm long, lies on the floor of a straight tube. A very soft part of 50 mm
// (bending stiffness 4e-7 N m2) connects the heavy part of the wire with the introducer. The direction of
// gravity tilts towards the tip by 1 degree per second.
Slope tilt(double friction, double friction_static, bool skew)
{
    Vector3d along(1, 0, 0), up(0, 0, 1);
    if (skew) { // a direction that is not one of the field's lattice
        along = Vector3d(std::cos(0.3) * std::cos(0.4), std::cos(0.3) * std::sin(0.4), -std::sin(0.3));
        up = Vector3d(std::sin(0.3) * std::cos(0.4), std::sin(0.3) * std::sin(0.4), std::cos(0.3));
    }
    const double tube_m = 0.003;
    Path path(-0.03 * along, along, up);
    path.straight(0.4);
    LumenField field = tube_field(path, tube_m, 1);
    Knot heavy{.bend_N_m2 = 1e-4, .twist_N_m2 = 1e-4 / 1.3, .mass_kg_per_m = 0.1, .friction = friction};
    Knot tie{.bend_N_m2 = 4e-7, .twist_N_m2 = 4e-7, .mass_kg_per_m = 5e-4, .friction = friction};
    heavy.friction_static = tie.friction_static = friction_static;
    Tool tool = uniform_tool(heavy, 0.45, 0.008);
    Knot heavy_end = heavy, tie_begin = tie;
    heavy_end.arc_m = tie_begin.arc_m = 0.25;
    tie.arc_m = 0.45;
    tool.knots = {heavy, heavy_end, tie_begin, tie};
    Rig rig({tool}, &field,
            {.inserted_m = {0.3}, .mouth_m = -(tube_m - wire_radius_m - 2e-6) * up, .direction = along});
    rig.set_gravity(-gravity_m_s2 * up);
    rig.step(1500);
    double start = rig.position(0).dot(along), expected = std::atan(friction_static) / degree;
    Slope slope;
    slope.travel.label = "mu " + number_text(friction);
    slope.travel.dots = true;
    const double first = std::max(0.0, expected - 3);
    for (int tick = 0; tick < 1000; tick++) { // a sudden load would swing beyond what friction holds
        const double angle = first * tick / 1000;
        rig.set_gravity(gravity_m_s2 * (std::sin(angle * degree) * along - std::cos(angle * degree) * up));
        rig.step();
    }
    for (double angle = first; angle < expected + 2; angle += 1e-3) {
        rig.set_gravity(gravity_m_s2 * (std::sin(angle * degree) * along - std::cos(angle * degree) * up));
        rig.step();
        double travel_mm = (rig.position(0).dot(along) - start) * 1e3;
        if (slope.onset_deg == 0 && travel_mm > 0.02) slope.onset_deg = angle;
        if (slope.travel.x.empty() || angle > slope.travel.x.back() + 0.1) {
            slope.travel.x.push_back(angle);
            slope.travel.y.push_back(travel_mm);
        }
    }
    return slope;
}

void incline(Result &result, bool quick)
{
    result.title = "Incline: stick and slip";
    result.setup = "A heavy rod on the floor of a straight tube, tied to the mouth by a very soft wire, "
                   "while gravity tilts by 1 degree "
                   "per second. Slips: moved by 0.02 mm. Along the field's lattice and askew to it.";
    result.formula = "holds while tan(angle) <= mu, the static one where the two differ";
    result.source = "Coulomb";
    Plot plot{"Rod on an incline", "angle (degrees)", "way of the tip (mm)", {}};
    for (bool skew : {false, true}) {
        for (double mu : {0.1, 0.2, 0.3, 0.4}) {
            if (quick && mu != 0.2) continue;
            Slope slope = tilt(mu, mu, skew);
            result.absolute(std::string(skew ? "askew" : "aligned") + ".mu_" + number_text(mu), "deg",
                            std::atan(mu) / degree, slope.onset_deg, 0.6);
            if (skew) plot.series.push_back(slope.travel);
        }
        // A rod at rest holds by its static friction, however low its kinetic one is.
        for (double kinetic : {0.1, 0.17}) {
            if (quick && kinetic != 0.1) continue;
            const double held = 0.2;
            result.absolute(std::string(skew ? "askew" : "aligned") + ".static_" + number_text(held) +
                                ".kinetic_" + number_text(kinetic),
                            "deg", std::atan(held) / degree, tilt(kinetic, held, skew).onset_deg, 0.6);
        }
    }
    result.plots.push_back(plot);
}

// --- sliding ---

// A heavy, short rod on the floor of a straight tube is pushed by less than its friction can hold. Every node
// hangs on a bristle of k = 2 kN/m, and the rod between them is elastic, so the hand feels EA q tanh(q L)
// with q^2 = k / (EA element).
void held_by_bristles(Result &result)
{
    const double tube_m = 0.004, length = 0.06, element = 0.003, axial_N = 3000, way_m = 4e-7;
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.2);
    LumenField field = tube_field(path, tube_m, 0);
    Knot knot{.bend_N_m2 = 1e-4, .twist_N_m2 = 1e-4, .mass_kg_per_m = 0.1, .friction = 0.9};
    Rig rig({uniform_tool(knot, 0.2, element)}, &field,
            {.inserted_m = {length}, .mouth_m = {0, 0, -(tube_m - wire_radius_m - 2e-6)}});
    rig.set_gravity({0, 0, -50 * gravity_m_s2}); // every node presses on the wall
    rig.step(3000);
    const double before_N = rig.handle_axial(), before_m = rig.inserted();
    rig.feed(way_m);
    rig.step(1000);
    const double q = std::sqrt(2000 / (axial_N * element));
    result.relative("held.stiffness", "kN/m", axial_N * q * std::tanh(q * length) / 1e3,
                    (rig.handle_axial() - before_N) / (rig.inserted() - before_m) / 1e3, 5);
}

// A catheter is pushed along the floor over a wire that its hand holds. The wall's friction on the catheter
// acts on the catheter's hand alone, and the catheter's surface lies on the wall.
void catheter_on_the_floor(Result &result)
{
    const double tube_m = 0.004, outer_m = 800e-6, speed_m_s = 0.002, mu = 0.3;
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.4);
    LumenField field = tube_field(path, tube_m, 0);
    Knot wire{.bend_N_m2 = 1e-5, .twist_N_m2 = 1e-5, .mass_kg_per_m = 0.005};
    Knot catheter{.bend_N_m2 = 1e-4,
                  .twist_N_m2 = 1e-4,
                  .mass_kg_per_m = 0.02,
                  .radius_m = outer_m,
                  .radius_inner_m = 500e-6,
                  .friction = mu};
    Rig rig({uniform_tool(wire, 0.45, 0.003), uniform_tool(catheter, 0.45, 0.003)}, &field,
            {.inserted_m = {0.31, 0.28}, .mouth_m = {0, 0, -(tube_m - outer_m - 2e-6)}});
    rig.set_gravity({0, 0, -gravity_m_s2});
    double hand_N[2] = {0, 0}, normal_N = 0, height_m = 0, way_m = 0;
    for (int tick = 0; tick < 3000; tick++) {
        way_m += speed_m_s * 1e-3;
        rig.feed(way_m, 1);
        rig.step();
        if (tick < 2500) continue;
        for (unsigned k : {0u, 1u}) hand_N[k] += rig.handle_axial(k) / 500;
        for (unsigned i = 0; i < rig.free_count(); i++)
            if (rig.position(i)[0] < rig.inserted(1))
                normal_N += rig.contact_force(i).value_or(Vector3d::Zero())[2] / 500;
        height_m += rig.position(rig.free_count() / 2)[2] / 500;
    }
    const double drag_N = 20 * rig.inserted(1) * 0.025 * speed_m_s; // of the blood
    result.relative("catheter.hand", "N", mu * normal_N, hand_N[1] - drag_N, 4);
    result.absolute("catheter.wires_hand", "N", 0, hand_N[0], 0.003);
    result.absolute("catheter.height", "mm", -(tube_m - outer_m) * 1e3, height_m * 1e3, 0.01);
}

void sliding(Result &result, bool quick)
{
    result.title = "Sliding along a floor";
    result.setup = "0.3 m of rod, EI 1e-4 N m2, 20 g/m, on the floor of a straight tube whose mouth lies at "
                   "the floor too; pushed and "
                   "pulled at 2 mm/s. Half the difference of the hand's force, mean over 1 mm, less the drag "
                   "of blood (20/s m v), against the wall's normal forces and "
                   "against the weight. The static coefficient is twice the kinetic one. A short rod that "
                   "sticks, against its bristles; a catheter over a held wire.";
    result.formula = "F = kinetic mu N; EA q tanh(q L), q^2 = k / (EA element) while it sticks";
    result.source = "Coulomb";
    for (double mu : {0.1, 0.3, 0.5}) {
        if (quick && mu != 0.3) continue;
        const double tube_m = 0.004, speed_m_s = 0.002;
        Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
        path.straight(0.4);
        LumenField field = tube_field(path, tube_m, 0);
        Knot knot{.bend_N_m2 = 1e-4, .twist_N_m2 = 1e-4 / 1.3, .mass_kg_per_m = 0.02, .friction = mu};
        knot.friction_static = std::min(1.0, 2 * mu);
        Rig rig({uniform_tool(knot, 0.45, 0.003)}, &field,
                {.inserted_m = {0.3}, .mouth_m = {0, 0, -(tube_m - wire_radius_m - 2e-6)}});
        rig.set_gravity({0, 0, -gravity_m_s2});
        double mean[2] = {0, 0}, normal = 0, along[2] = {0, 0}, hand = 0, length = 0;
        for (int way : {0, 1}) {
            for (int tick = 0; tick < 2000; tick++) {
                hand += way == 0 ? speed_m_s * 1e-3 : -speed_m_s * 1e-3;
                rig.feed(hand);
                rig.step();
                if (tick < 1500) continue;
                mean[way] += rig.handle_axial() / 500;
                length += rig.inserted() / 1000;
                for (unsigned i = 0; i < rig.free_count(); i++) {
                    const Vector3d wall = rig.contact_force(i).value_or(Vector3d::Zero());
                    normal += wall[2] / 1000;
                    along[way] += wall[0] / 500;
                }
            }
        }
        double force = (mean[0] - mean[1]) / 2 - 20 * length * 0.02 * speed_m_s;
        result.relative("mu_" + number_text(mu) + ".wall", "N", mu * normal, force, 1);
        result.relative("mu_" + number_text(mu) + ".weight", "N", mu * length * 0.02 * gravity_m_s2, force,
                        3);
        result.relative("mu_" + number_text(mu) + ".reported", "N", mu * normal, (along[1] - along[0]) / 2,
                        1);
    }
    held_by_bristles(result);
    catheter_on_the_floor(result);
}

// --- helix in a tube ---

double pitch(double bend, double force_N)
{
    return 2 * M_PI * std::sqrt(2 * bend / force_N);
}

struct Coil {
    double pitch_m, wall_N_m;
    Series phase;
};

Coil press(double bend, double force_N, double gap_m, double length_m, double element_m, int ticks)
{
    double tube_m = gap_m + wire_radius_m;
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(length_m + 0.08);
    LumenField field = tube_field(path, tube_m, tube_m < 0.003 ? 1 : 0);
    Knot knot{.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3};
    Rig rig({uniform_tool(knot, length_m + 0.1, element_m)}, &field, {{length_m}});
    std::vector<Vector3d> loose;
    for (unsigned i = 0; i < rig.free_count(); i++) {
        double x = rig.position(i)[0], turns = x / (2 * pitch(bend, force_N));
        double out = gap_m * 0.9 * std::min(1.0, turns);
        loose.push_back({x, out * std::cos(2 * M_PI * turns), out * std::sin(2 * M_PI * turns)});
    }
    rig.place(loose);
    for (int tick = 0; tick < ticks; tick++) {
        rig.set_tip_load({-force_N * std::min(1.0, (tick + 0.1 * ticks) / (0.4 * ticks)), 0, 0});
        rig.step();
    }
    Coil coil{0, 0, {"ours", {}, {}, true}};
    double phase = 0, before = 0, wall = 0, over = 0;
    for (unsigned i = 0; i < rig.free_count(); i++) {
        Vector3d p = rig.position(i);
        double angle = std::atan2(p[2], p[1]);
        phase = i == 0 ? angle : unwrapped(angle, before);
        before = phase;
        coil.phase.x.push_back(p[0]);
        coil.phase.y.push_back(std::fabs(phase) / 2 / M_PI);
        if (p[0] > 0.3 * length_m && p[0] < 0.7 * length_m) {
            wall += rig.contact_force(i).value_or(Vector3d::Zero()).norm();
            over += element_m;
        }
    }
    std::vector<std::size_t> inside;
    for (std::size_t i = 0; i < coil.phase.x.size(); i++) {
        if (coil.phase.x[i] > 0.25 * length_m && coil.phase.x[i] < 0.75 * length_m) inside.push_back(i);
    }
    std::size_t a = inside.front(), b = inside.back();
    coil.pitch_m = (coil.phase.x[a] - coil.phase.x[b]) / std::fabs(coil.phase.y[a] - coil.phase.y[b]);
    coil.wall_N_m = wall / over;
    return coil;
}

void helix(Result &result, bool quick)
{
    result.title = "Pressed rod coils in its tube";
    result.setup = "A weightless rod in a straight frictionless tube, a dead load at its free tip raised "
                   "slowly. It starts as a loose "
                   "coil of twice the pitch, so that it coils in one sense. Middle half of the length: pitch "
                   "from the phase, wall force per length.";
    result.formula = "pitch = 2 pi sqrt(2 EI / F); wall force = gap F^2 / 4 EI (small slopes)";
    result.source = "Lubinski et al. 1962; Mitchell 1988";
    struct Setting {
        double bend, force, gap, length, element;
    };
    for (auto [bend, force, gap, length, element] :
         {Setting{1e-4, 1, 0.0011, 0.8, 0.004}, Setting{1e-4, 0.5, 0.0011, 0.8, 0.004},
          Setting{3e-4, 2, 0.0015, 0.9, 0.004}}) {
        if (quick && force != 1) continue;
        Coil coil = press(bend, force, gap, length, element, quick ? 6000 : 20000);
        std::string name = "EI_" + power_text(bend) + ".F_" + number_text(force) + "N";
        result.relative("pitch." + name, "mm", pitch(bend, force) * 1e3, coil.pitch_m * 1e3, 5);
        result.relative("wall." + name, "N/m", gap * force * force / 4 / bend, coil.wall_N_m, 5);
        if (force != 1) continue;
        Series line{"closed form through the middle", {}, {}};
        std::size_t middle = coil.phase.x.size() / 2;
        for (double x : {0.0, length}) {
            double sense = coil.phase.y.front() < coil.phase.y.back() ? -1 : 1;
            line.x.push_back(x);
            line.y.push_back(coil.phase.y[middle] + sense * (x - coil.phase.x[middle]) / pitch(bend, force));
        }
        result.plots.push_back({"Phase of a coiled rod", "x (m)", "turns", {line, coil.phase}});
    }
}

} // namespace

std::vector<Case> wall_cases()
{
    return {{"capstan", capstan}, {"incline", incline}, {"sliding", sliding}, {"helix", helix}};
}

} // namespace crn::validate
