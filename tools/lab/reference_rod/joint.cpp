// We first take derivatives with respect to the two edges of a joint, and convert them to derivatives with
// respect to the nodes. The rear edge is the vector node - rear node, and the front edge is the vector front
// node - node.
#include "tools/lab/reference_rod/joint.hpp"
#include <Eigen/Geometry>

namespace crn::reference
{
namespace
{

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

Matrix cross_matrix(const Vector &v)
{
    Matrix m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
}

// Values that all measures share.
struct Frame {
    double rear_m, front_m, chi; // 1 + cos of the turn
    Vector te, tf, mean, kb;     // tangents; (te + tf) / chi; curvature binormal
};

constexpr int at_rear = 0, rear_angle = 3, at_node = 4, front_angle = 7,
              at_front = 8; // places among the unknowns

void spread(const Vector &de, const Vector &df, Slope &slope)
{
    slope.segment<3>(at_rear) = -de;
    slope.segment<3>(at_node) = de - df;
    slope.segment<3>(at_front) = df;
}

// Converts second derivatives with respect to the edges to second derivatives with respect to the nodes; the
// rows of the matrix `ef` belong to the rear edge.
void spread(const Matrix &ee, const Matrix &ff, const Matrix &ef, Second &second)
{
    const Matrix fe = ef.transpose();
    second.block<3, 3>(at_rear, at_rear) = ee;
    second.block<3, 3>(at_rear, at_node) = -ee + ef;
    second.block<3, 3>(at_rear, at_front) = -ef;
    second.block<3, 3>(at_node, at_rear) = -ee + fe;
    second.block<3, 3>(at_node, at_node) = ee - ef - fe + ff;
    second.block<3, 3>(at_node, at_front) = ef - ff;
    second.block<3, 3>(at_front, at_rear) = -fe;
    second.block<3, 3>(at_front, at_node) = fe - ff;
    second.block<3, 3>(at_front, at_front) = ff;
}

// Converts second derivatives with respect to an angle and the two edges to second derivatives with respect
// to the angle and the nodes.
void spread_angle(int angle, const Vector &de, const Vector &df, Second &second)
{
    Slope row = Slope::Zero();
    spread(de, df, row);
    second.col(angle) += row;
    second.row(angle) += row.transpose();
}

// The curvature towards the material axis d1 is kb . (ue + uf) / 2, where kb is the curvature vector of the
// joint, and ue and uf are the second axes u = t x d1 of its two edges. With u = -d1, the formula of the
// curvature gives the curvature towards the second material axis t x d1. `ve` and `vf` are -du / d(angle),
// which is d1 for the curvature towards d1, and t x d1 for the curvature towards t x d1.
void curvature(const Frame &f, const Vector &ue, const Vector &uf, const Vector &ve, const Vector &vf,
               bool with_second, Measure &out)
{
    const Vector mean_u = (ue + uf) / f.chi;
    const double k = out.value = 0.5 * f.kb.dot(ue + uf);
    const Vector front_cross = f.tf.cross(mean_u), rear_cross = f.te.cross(mean_u);
    spread((-k * f.mean + front_cross) / f.rear_m, (-k * f.mean - rear_cross) / f.front_m, out.slope);
    out.slope[rear_angle] = -0.5 * f.kb.dot(ve);
    out.slope[front_angle] = -0.5 * f.kb.dot(vf);
    if (!with_second) return;

    const Matrix one = Matrix::Identity(), tt = 2.0 * k * f.mean * f.mean.transpose();
    const Matrix a = front_cross * f.mean.transpose(), b = rear_cross * f.mean.transpose();
    const Matrix ke = f.kb * ue.transpose(), kf = f.kb * uf.transpose();
    const Matrix ee = (tt - a - a.transpose() - k / f.chi * (one - f.te * f.te.transpose()) +
                       0.25 * (ke + ke.transpose())) /
                      (f.rear_m * f.rear_m);
    const Matrix ff = (tt + b + b.transpose() - k / f.chi * (one - f.tf * f.tf.transpose()) +
                       0.25 * (kf + kf.transpose())) /
                      (f.front_m * f.front_m);
    const Matrix ef = (tt - k / f.chi * (one + f.te * f.tf.transpose()) - a +
                       f.mean * rear_cross.transpose() - cross_matrix(mean_u)) /
                      (f.rear_m * f.front_m);
    out.second.setZero();
    spread(ee, ff, ef, out.second);
    out.second(rear_angle, rear_angle) = -0.5 * f.kb.dot(ue);
    out.second(front_angle, front_angle) = -0.5 * f.kb.dot(uf);
    const auto angle_edge = [&](int angle, const Vector &v) {
        const double half = 0.5 * f.kb.dot(v);
        spread_angle(angle, (half * f.mean - f.tf.cross(v) / f.chi) / f.rear_m,
                     (half * f.mean + f.te.cross(v) / f.chi) / f.front_m, out.second);
    };
    angle_edge(rear_angle, ve);
    angle_edge(front_angle, vf);
}

void twist_of(const Frame &f, double value, bool with_second, Measure &out)
{
    out.value = value;
    spread(f.kb / (2.0 * f.rear_m), f.kb / (2.0 * f.front_m), out.slope);
    out.slope[rear_angle] = -1.0;
    out.slope[front_angle] = 1.0;
    if (!with_second) return;
    const Matrix e = f.kb * (f.te + f.mean).transpose(), g = f.kb * (f.tf + f.mean).transpose();
    out.second.setZero();
    spread(-(e + e.transpose()) / (4.0 * f.rear_m * f.rear_m),
           -(g + g.transpose()) / (4.0 * f.front_m * f.front_m),
           (2.0 / f.chi * cross_matrix(f.te) - f.kb * f.mean.transpose()) / (2.0 * f.rear_m * f.front_m),
           out.second);
}

} // namespace

void joint_measures(const Joint &joint, bool with_second, Measure &curvature1, Measure &curvature2,
                    Measure &twist)
{
    Frame f;
    f.rear_m = joint.rear.norm();
    f.front_m = joint.front.norm();
    f.te = joint.rear / f.rear_m;
    f.tf = joint.front / f.front_m;
    f.chi = 1.0 + f.te.dot(f.tf);
    f.mean = (f.te + f.tf) / f.chi;
    f.kb = 2.0 / f.chi * f.te.cross(f.tf);
    const Vector &d1e = joint.rear_d1, &d1f = joint.front_d1;
    const Vector d2e = f.te.cross(d1e), d2f = f.tf.cross(d1f);
    curvature(f, d2e, d2f, d1e, d1f, with_second, curvature1);
    curvature(f, -d1e, -d1f, d2e, d2f, with_second, curvature2);
    twist_of(f, joint.twist, with_second, twist);
}

} // namespace crn::reference
