#include "host/igtl/pack.hpp"
#include <cstring>
#include <openigtlink/igtlImageMessage.h>
#include <openigtlink/igtlStatusMessage.h>
#include <openigtlink/igtlTransformMessage.h>

namespace crn
{

namespace
{

std::vector<std::uint8_t> bytes_of(igtl::MessageBase &message, const std::string &name, std::uint32_t tick)
{
    message.SetDeviceName(name.c_str());
    const std::uint64_t milliseconds = tick % 1000;
    // The fraction is rounded up, so that a client that truncates it to milliseconds gets the same tick.
    const std::uint64_t fraction = ((milliseconds << 32) + 999) / 1000;
    message.SetTimeStamp(tick / 1000, static_cast<unsigned>(fraction));
    message.Pack();
    const auto *begin = static_cast<const std::uint8_t *>(message.GetPackPointer());
    return {begin, begin + message.GetPackSize()};
}

void fill(igtl::Matrix4x4 &matrix, const IgtlPose &pose)
{
    igtl::IdentityMatrix(matrix);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            matrix[row][column] = static_cast<float>(pose.matrix()(row, column));
}

std::vector<std::uint8_t> pack_content(const std::string &name, std::uint32_t tick, const IgtlPose &pose)
{
    const igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
    igtl::Matrix4x4 matrix;
    fill(matrix, pose);
    message->SetMatrix(matrix);
    return bytes_of(*message, name, tick);
}

std::vector<std::uint8_t> pack_content(const std::string &name, std::uint32_t tick,
                                       const IgtlPicture &picture)
{
    constexpr float slice_mm = 1.0f; // a picture has no depth; viewers need a thickness
    const igtl::ImageMessage::Pointer message = igtl::ImageMessage::New();
    const auto pixel_mm = static_cast<float>(picture.pixel_mm);
    message->SetDimensions(picture.size, picture.size, 1);
    message->SetSpacing(pixel_mm, pixel_mm, slice_mm);
    message->SetNumComponents(1);
    message->SetScalarTypeToUint8();
    message->SetEndian(igtl::ImageMessage::ENDIAN_BIG);
    message->SetCoordinateSystem(igtl::ImageMessage::COORDINATE_RAS);
    igtl::Matrix4x4 matrix;
    fill(matrix, picture.pose);
    message->SetMatrix(matrix);
    message->AllocateScalars();
    std::memcpy(message->GetScalarPointer(), picture.grey->data(), picture.grey->size());
    return bytes_of(*message, name, tick);
}

std::vector<std::uint8_t> pack_content(const std::string &name, std::uint32_t tick, const IgtlStatus &status)
{
    const igtl::StatusMessage::Pointer message = igtl::StatusMessage::New();
    message->SetCode(status.is_running ? igtl::StatusMessage::STATUS_OK
                                       : igtl::StatusMessage::STATUS_SHUT_DOWN);
    message->SetSubCode(tick);
    message->SetErrorName("");
    message->SetStatusString(status.text.c_str());
    return bytes_of(*message, name, tick);
}

} // namespace

std::vector<std::uint8_t> pack_igtl(const std::string &name, const IgtlItem &item)
{
    return std::visit([&](const auto &content) { return pack_content(name, item.tick, content); },
                      item.content);
}

} // namespace crn
