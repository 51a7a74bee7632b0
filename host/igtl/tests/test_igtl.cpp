// Tests the conversion of positions in the patient to the axes and millimetres of OpenIGTLink, and that rays
// from the X-ray source through the patient meet the picture at the right pixels. libOpenIGTLink reads every
// kind of message. The bounded memory of messages must keep the newest value of every name, and addresses are
// read or refused.
#include "host/igtl/address.hpp"
#include "host/igtl/geometry.hpp"
#include "host/igtl/outbox.hpp"
#include "host/igtl/pack.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <openigtlink/igtlImageMessage.h>
#include <openigtlink/igtlMessageHeader.h>
#include <openigtlink/igtlStatusMessage.h>
#include <openigtlink/igtlTransformMessage.h>
#include <stdexcept>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

constexpr double float_mm = 1e-4; // messages hold 32-bit floats: 6e-5 mm at 1 m

void assert_near(const char *name, double value, double expected, double allowed)
{
    if (!(std::abs(value - expected) <= allowed))
        fail_msg("%s = %.9g, expected %.9g, allowed %.2g", name, value, expected, allowed);
}

void assert_vector(const char *name, const Eigen::Vector3d &value, const Eigen::Vector3d &expected,
                   double allowed)
{
    for (int axis = 0; axis < 3; ++axis) assert_near(name, value[axis], expected[axis], allowed);
}

WireFrame straight_wire(const Eigen::Vector3d &tip_m, const Eigen::Vector3d &out)
{
    WireFrame wire;
    for (int i = 0; i < 5; ++i) {
        WireNode node;
        node.position_m = tip_m - 0.004 * i * out;
        node.arc_m = 0.004 * i;
        wire.nodes.push_back(node);
    }
    wire.tip_arc_m = {0.0, 0.006};
    return wire;
}

CArm tilted()
{
    CArm carm;
    carm.primary_deg = 40.0;
    carm.secondary_deg = -25.0;
    carm.isocentre_m = {0.01, 0.15, -0.03};
    carm.field_m = 0.2;
    return carm;
}

// Returns the message as a client receives it: first the header, and then the body with its checksum.
template <class Message> typename Message::Pointer read_back(const std::vector<std::uint8_t> &bytes)
{
    const igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
    header->InitPack();
    assert_true(bytes.size() >= static_cast<std::size_t>(header->GetPackSize()));
    std::memcpy(header->GetPackPointer(), bytes.data(), static_cast<std::size_t>(header->GetPackSize()));
    header->Unpack();
    const typename Message::Pointer message = Message::New();
    message->SetMessageHeader(header);
    message->AllocatePack();
    const auto body = static_cast<std::size_t>(message->GetPackBodySize());
    assert_int_equal(bytes.size(), static_cast<std::size_t>(header->GetPackSize()) + body);
    std::memcpy(message->GetPackBodyPointer(), bytes.data() + header->GetPackSize(), body);
    assert_true(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY);
    return message;
}

std::uint32_t tick_of(igtl::MessageBase &message)
{
    unsigned seconds = 0, fraction = 0;
    message.GetTimeStamp(&seconds, &fraction);
    return seconds * 1000 + static_cast<std::uint32_t>((std::uint64_t{fraction} * 1000) >> 32);
}

void a_place_left_up_and_in_front_has_its_right_anterior_and_superior_millimetres(void **)
{
    assert_vector("place", ras_place_mm({0.1, 0.2, 0.03}), {-100.0, 30.0, 200.0}, 1e-9);
    assert_vector("left", ras_direction(Eigen::Vector3d::UnitX()), {-1.0, 0.0, 0.0}, 0.0);
    assert_vector("head", ras_direction(Eigen::Vector3d::UnitY()), {0.0, 0.0, 1.0}, 0.0);
    assert_vector("front", ras_direction(Eigen::Vector3d::UnitZ()), {0.0, 1.0, 0.0}, 0.0);
}

void the_frame_of_a_tip_begins_at_the_tip_and_points_out_of_it(void **)
{
    const Eigen::Vector3d out = Eigen::Vector3d(1.0, 2.0, -0.5).normalized();
    const WireFrame wire = straight_wire({0.02, 0.3, 0.01}, out);
    const IgtlPose leading = *tip_pose(wire, wire.tip_arc_m[0]), second = *tip_pose(wire, wire.tip_arc_m[1]);
    assert_vector("tip", leading.translation(), {-20.0, 10.0, 300.0}, 1e-9);
    assert_vector("second tip", second.translation() - leading.translation(), -6.0 * ras_direction(out),
                  1e-9);
    assert_vector("z axis", leading.linear().col(2), ras_direction(out), 1e-12);
    assert_near("determinant", leading.linear().determinant(), 1.0, 1e-12);
    assert_near("orthogonality",
                (leading.linear().transpose() * leading.linear() - Eigen::Matrix3d::Identity()).norm(), 0.0,
                1e-12);
}

void a_tip_that_points_to_the_head_has_the_axes_of_the_patient(void **)
{
    const IgtlPose pose = *tip_pose(straight_wire({0.0, 0.1, 0.0}, Eigen::Vector3d::UnitY()), 0.0);
    assert_near("rotation", (pose.linear() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12);
    assert_false(tip_pose(WireFrame{}, 0.0).has_value());
}

void the_c_arm_at_the_front_looks_from_the_back_to_the_front(void **)
{
    const IgtlPose pose = carm_pose(CArm{});
    assert_vector("right in the picture", pose.linear().col(0), {-1.0, 0.0, 0.0}, 1e-12);
    assert_vector("up in the picture", pose.linear().col(1), {0.0, 0.0, 1.0}, 1e-12);
    assert_vector("to the detector", pose.linear().col(2), {0.0, 1.0, 0.0}, 1e-12);
    assert_near("determinant", carm_pose(tilted()).linear().determinant(), 1.0, 1e-12);
    assert_vector("isocentre", carm_pose(tilted()).translation(), {-10.0, -30.0, 150.0}, 1e-9);
}

// The X-ray source, a point in the patient, and the pixel that shows this point must lie on one straight
// line.
void a_pixel_lies_on_the_ray_from_the_source_through_what_it_shows(void **)
{
    const int size = 512;
    const CArm carm = tilted();
    const IgtlPicture picture = picture_place(carm, size);
    const IgtlPose arm = carm_pose(carm);
    const Eigen::Vector3d source = arm * Eigen::Vector3d(0.0, 0.0, -1e3 * carm.source_isocentre_m);
    assert_near("pixel", picture.pixel_mm, 200.0 / size, 1e-12);
    for (const Eigen::Vector3d &place_m :
         {Eigen::Vector3d(0.01, 0.15, -0.03), Eigen::Vector3d(0.05, 0.12, 0.02),
          Eigen::Vector3d(-0.02, 0.18, -0.06)}) {
        Eigen::Vector2d pixel;
        assert_true(project(make_view(carm, size), place_m, pixel));
        const Eigen::Vector3d shown =
            picture.pose * Eigen::Vector3d((pixel.x() - 0.5 * size) * picture.pixel_mm,
                                           (pixel.y() - 0.5 * size) * picture.pixel_mm, 0.0);
        const Eigen::Vector3d ray = (ras_place_mm(place_m) - source).normalized();
        assert_near("distance from the ray", (shown - source).cross(ray).norm(), 0.0, 1e-9);
        assert_near("distance from the source", arm.linear().col(2).dot(shown - source), 1050.0, 1e-9);
    }
}

void libopenigtlink_reads_a_transform_with_its_tick(void **)
{
    const IgtlPose pose = carm_pose(tilted());
    const auto message = read_back<igtl::TransformMessage>(pack_igtl("CArm", {61'234, pose}));
    assert_string_equal(message->GetDeviceName(), "CArm");
    assert_int_equal(tick_of(*message), 61'234);
    igtl::Matrix4x4 matrix;
    message->GetMatrix(matrix);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            assert_near("element", matrix[row][column], pose.matrix()(row, column), float_mm);
}

void every_tick_of_a_second_survives_the_time_stamp(void **)
{
    for (std::uint32_t tick = 5000; tick < 6000; ++tick) {
        const auto message = read_back<igtl::TransformMessage>(pack_igtl("a", {tick, IgtlPose::Identity()}));
        assert_int_equal(tick_of(*message), tick);
    }
}

void libopenigtlink_reads_a_picture_with_its_place(void **)
{
    IgtlPicture picture = picture_place(tilted(), 64);
    auto grey = std::make_shared<std::vector<std::uint8_t>>(64 * 64);
    for (std::size_t i = 0; i < grey->size(); ++i) (*grey)[i] = static_cast<std::uint8_t>(i * 7 + i / 64);
    picture.grey = grey;
    const auto message = read_back<igtl::ImageMessage>(pack_igtl("Fluoroscopy", {40, picture}));
    int columns = 0, rows = 0, slices = 0;
    message->GetDimensions(columns, rows, slices);
    assert_int_equal(columns, 64);
    assert_int_equal(rows, 64);
    assert_int_equal(slices, 1);
    assert_int_equal(message->GetCoordinateSystem(), igtl::ImageMessage::COORDINATE_RAS);
    assert_int_equal(message->GetScalarType(), igtl::ImageMessage::TYPE_UINT8);
    float spacing[3];
    message->GetSpacing(spacing);
    assert_near("spacing", spacing[0], picture.pixel_mm, 1e-6);
    assert_near("spacing", spacing[1], picture.pixel_mm, 1e-6);
    igtl::Matrix4x4 matrix;
    message->GetMatrix(matrix);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            assert_near("element", matrix[row][column], picture.pose.matrix()(row, column), float_mm);
    assert_memory_equal(message->GetScalarPointer(), grey->data(), grey->size());
}

void libopenigtlink_reads_a_status(void **)
{
    const auto running =
        read_back<igtl::StatusMessage>(pack_igtl("Cournand", {1234, IgtlStatus{true, "on"}}));
    assert_int_equal(running->GetCode(), igtl::StatusMessage::STATUS_OK);
    assert_int_equal(running->GetSubCode(), 1234);
    assert_string_equal(running->GetStatusString(), "on");
    const auto ended =
        read_back<igtl::StatusMessage>(pack_igtl("Cournand", {1235, IgtlStatus{false, "end"}}));
    assert_int_equal(ended->GetCode(), igtl::StatusMessage::STATUS_SHUT_DOWN);
}

void a_full_outbox_drops_the_oldest_moment_and_keeps_the_newest_value_of_every_name(void **)
{
    Outbox<int> outbox;
    outbox.push({{"picture", 0}, {"tip", 0}});
    for (int i = 1; i <= 20; ++i) outbox.push({{"tip", i}});
    assert_int_equal(outbox.size(), Outbox<int>::moments_max);
    assert_int_equal(outbox.dropped(), 21 - Outbox<int>::moments_max);
    const Outbox<int>::Moment first = outbox.pop();
    assert_int_equal(first.at("tip"), 13);
    assert_int_equal(first.at("picture"), 0);
    for (int i = 14; i <= 20; ++i) assert_int_equal(outbox.pop().at("tip"), i);
    assert_true(outbox.is_empty());
}

void an_address_is_a_port_or_a_host_with_a_port(void **)
{
    assert_string_equal(parse_igtl_address("18944").text().c_str(), "127.0.0.1:18944");
    assert_true(parse_igtl_address("18944").is_local());
    assert_string_equal(parse_igtl_address("0.0.0.0:1").text().c_str(), "0.0.0.0:1");
    assert_false(parse_igtl_address("0.0.0.0:1").is_local());
    assert_string_equal(parse_igtl_address("[::1]:18944").text().c_str(), "[::1]:18944");
    assert_true(parse_igtl_address("[::1]:18944").is_local());
    assert_true(parse_igtl_address("localhost:0").is_local());
    for (const char *bad :
         {"", "65536", "-1", "+5", "18944x", "host", "host:", ":18944", "::1:18944", "[]:1", "1 "}) {
        try {
            parse_igtl_address(bad);
            fail_msg("'%s' was accepted", bad);
        } catch (const std::runtime_error &error) {
            assert_non_null(std::strstr(error.what(), "HOST:PORT"));
        }
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_place_left_up_and_in_front_has_its_right_anterior_and_superior_millimetres),
        cmocka_unit_test(the_frame_of_a_tip_begins_at_the_tip_and_points_out_of_it),
        cmocka_unit_test(a_tip_that_points_to_the_head_has_the_axes_of_the_patient),
        cmocka_unit_test(the_c_arm_at_the_front_looks_from_the_back_to_the_front),
        cmocka_unit_test(a_pixel_lies_on_the_ray_from_the_source_through_what_it_shows),
        cmocka_unit_test(libopenigtlink_reads_a_transform_with_its_tick),
        cmocka_unit_test(every_tick_of_a_second_survives_the_time_stamp),
        cmocka_unit_test(libopenigtlink_reads_a_picture_with_its_place),
        cmocka_unit_test(libopenigtlink_reads_a_status),
        cmocka_unit_test(a_full_outbox_drops_the_oldest_moment_and_keeps_the_newest_value_of_every_name),
        cmocka_unit_test(an_address_is_a_port_or_a_host_with_a_port),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
