#include "host/picture/h264.hpp"
#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <wels/codec_api.h>

namespace crn
{
namespace
{

// With the quantisation parameter (QP) 23, the film of the demo has a PSNR of 34.8 dB (RGB) and a size of
// 14.7 MB.
constexpr int quality = 23; // QP, 0 .. 51, small is good

constexpr std::size_t start_code_bytes = 4; // before every NAL unit: 0 0 0 1
constexpr int type_mask = 31, type_sequence_parameters = 7, type_picture_parameters = 8;

// The factors convert RGB to the colour space BT.709 (ITU-R BT.709-6, 3.4): brightness 16 .. 235, colour
// differences 16 .. 240 around 128. The fixed-point factors that convert RGB have 16 binary places.
constexpr double red_share = 0.2126, blue_share = 0.0722, brightness_range = 219.0 / 255,
                 colour_range = 224.0 / 255;
constexpr int fixed(double value)
{
    return static_cast<int>(value * 65536 + (value < 0 ? -0.5 : 0.5));
}
constexpr int y_red = fixed(red_share * brightness_range), y_blue = fixed(blue_share * brightness_range);
constexpr int y_green = fixed(brightness_range) - y_red - y_blue;
// The three factors of each colour difference add up to 0, so that grey pixels have a colour difference of 0.
constexpr double cb_scale = colour_range / (2 * (1 - blue_share)),
                 cr_scale = colour_range / (2 * (1 - red_share));
constexpr int cb_red = fixed(-red_share * cb_scale), cb_blue = fixed((1 - blue_share) * cb_scale);
constexpr int cb_green = -cb_red - cb_blue;
constexpr int cr_red = fixed((1 - red_share) * cr_scale), cr_blue = fixed(-blue_share * cr_scale);
constexpr int cr_green = -cr_red - cr_blue;

// Lists the largest bit rate of each H.264 level in the profile High (tables ), in kbit/s.
struct Level {
    std::uint8_t number; // ten times the level's name
    long long kbit_per_s;
};
constexpr Level levels[] = {{10, 80},    {11, 240},   {12, 480},   {13, 960},   {20, 2500},   {21, 5000},
                            {30, 12500}, {31, 17500}, {32, 25000}, {41, 62500}, {50, 168750}, {51, 300000}};
constexpr std::size_t level_at = 3; // in the sequence parameters

void convert_brightness(const Image &image, std::uint8_t *out)
{
    const std::uint8_t *rgb = image.bytes.data();
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    for (std::size_t i = 0; i < pixels; ++i, rgb += 3)
        out[i] = static_cast<std::uint8_t>(
            16 + ((y_red * rgb[0] + y_green * rgb[1] + y_blue * rgb[2] + (1 << 15)) >> 16));
}

// Computes one colour value for a block of 2 x 2 pixels. H.264 places the colour value of a block at its left
// pair of pixels, between the two rows; neighbouring pixels in a row therefore have the weights 1 : 2 : 1.
// The sums that this function computes have 3 more binary places than a pixel value.
void convert_colour(const Image &image, std::uint8_t *out_blue, std::uint8_t *out_red)
{
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(image.width);
    for (int y = 0; y < image.height; y += 2)
        for (int x = 0; x < image.width; x += 2) {
            const std::uint8_t *upper = image.bytes.data() + static_cast<std::size_t>(y) * row_bytes + 3 * x;
            const std::uint8_t *lower = upper + row_bytes;
            const int left = x > 0 ? -3 : 0;
            int sum[3];
            for (int i = 0; i < 3; ++i)
                sum[i] = upper[left + i] + 2 * upper[i] + upper[3 + i] + lower[left + i] + 2 * lower[i] +
                         lower[3 + i];
            // The added offset makes the sum positive and makes the shift round the result.
            constexpr int offset = (128 << 19) + (1 << 18);
            *out_blue++ = static_cast<std::uint8_t>(
                (offset + cb_red * sum[0] + cb_green * sum[1] + cb_blue * sum[2]) >> 19);
            *out_red++ = static_cast<std::uint8_t>(
                (offset + cr_red * sum[0] + cr_green * sum[1] + cr_blue * sum[2]) >> 19);
        }
}

SEncParamExt parameters_of(ISVCEncoder &encoder, int width, int height, int pictures_per_s)
{
    SEncParamExt all;
    std::memset(&all, 0, sizeof all);
    encoder.GetDefaultParams(&all);
    all.iUsageType = CAMERA_VIDEO_REAL_TIME;
    all.iPicWidth = width;
    all.iPicHeight = height;
    all.fMaxFrameRate = static_cast<float>(pictures_per_s);
    all.iComplexityMode = MEDIUM_COMPLEXITY;
    all.iRCMode = RC_OFF_MODE;
    all.bEnableFrameSkip = false;
    all.uiIntraPeriod = static_cast<unsigned>(H264Encoder::seconds_between_keys * pictures_per_s);
    all.eSpsPpsIdStrategy = CONSTANT_ID;
    all.iEntropyCodingModeFlag = 1; // CABAC: 12 % fewer bytes
    all.iMultipleThreadIdc = 1;
    all.bEnableDenoise = false; // the noise belongs to the picture
    all.bEnableBackgroundDetection = false;
    all.bEnableAdaptiveQuant = false;
    all.bEnableSceneChangeDetect = false;
    SSpatialLayerConfig &layer = all.sSpatialLayers[0];
    layer.iVideoWidth = width;
    layer.iVideoHeight = height;
    layer.fFrameRate = all.fMaxFrameRate;
    layer.uiProfileIdc = PRO_HIGH;
    layer.iDLayerQp = quality;
    layer.sSliceArgument.uiSliceMode = SM_SINGLE_SLICE;
    layer.bVideoSignalTypePresent = true;
    layer.uiVideoFormat = VF_UNDEF;
    layer.bFullRange = false;
    layer.bColorDescriptionPresent = true;
    layer.uiColorPrimaries = CP_BT709;
    layer.uiTransferCharacteristics = TRC_BT709;
    layer.uiColorMatrix = CM_BT709;
    return all;
}

// Calls `take` once for every NAL unit (packet of H.264 data) of an encoded picture, without the unit's start
// code.
template <class Take> void for_each_unit(const SFrameBSInfo &info, Take take)
{
    for (int i = 0; i < info.iLayerNum; ++i) {
        const SLayerBSInfo &layer = info.sLayerInfo[i];
        const std::uint8_t *place = layer.pBsBuf;
        for (int k = 0; k < layer.iNalCount; ++k) {
            const auto bytes = static_cast<std::size_t>(layer.pNalLengthInByte[k]);
            if (bytes > start_code_bytes)
                take(std::span<const std::uint8_t>(place + start_code_bytes, bytes - start_code_bytes));
            place += bytes;
        }
    }
}

} // namespace

void H264Encoder::End::operator()(ISVCEncoder *encoder) const
{
    encoder->Uninitialize();
    WelsDestroySVCEncoder(encoder);
}

H264Encoder::~H264Encoder() = default;

H264Encoder::H264Encoder(int width, int height, int pictures_per_s)
    : width_(width), height_(height), pictures_per_s_(pictures_per_s)
{
    ISVCEncoder *encoder = nullptr;
    if (WelsCreateSVCEncoder(&encoder) != 0 || !encoder) fail("cannot start");
    encoder_.reset(encoder);
    silence();
    start();
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    planes_.resize(pixels + pixels / 2);
}

// Redirects the messages of the library openh264, which it would otherwise print on the terminal.
void H264Encoder::silence()
{
    WelsTraceCallback callback = keep_message;
    void *self = this;
    int level = WELS_LOG_ERROR;
    encoder_->SetOption(ENCODER_OPTION_TRACE_CALLBACK, &callback);
    encoder_->SetOption(ENCODER_OPTION_TRACE_CALLBACK_CONTEXT, &self);
    encoder_->SetOption(ENCODER_OPTION_TRACE_LEVEL, &level);
}

// Removes the memory address with which openh264 begins its messages, because it means nothing to a user.
void H264Encoder::keep_message(void *self, int, const char *text)
{
    H264Encoder &encoder = *static_cast<H264Encoder *>(self);
    if (encoder.said_[0]) return; // the first error is the cause of the others
    const std::string_view all(text), mark("Error:");
    const std::size_t begin = all.find(mark);
    all.substr(begin == all.npos ? 0 : begin + mark.size()).copy(encoder.said_, sizeof encoder.said_ - 1);
}

void H264Encoder::start()
{
    const SEncParamExt all = parameters_of(*encoder_, width_, height_, pictures_per_s_);
    if (encoder_->InitializeExt(&all) != cmResultSuccess)
        fail("does not encode " + std::to_string(width_) + " x " + std::to_string(height_) + " pixels at " +
                 std::to_string(pictures_per_s_) + " pictures per second",
             "choose a smaller --size");
    SFrameBSInfo info;
    std::memset(&info, 0, sizeof info);
    if (encoder_->EncodeParameterSets(&info) != cmResultSuccess) fail("gives no parameters");
    for_each_unit(info, [&](std::span<const std::uint8_t> unit) {
        const int type = unit[0] & type_mask;
        if (type == type_sequence_parameters) sequence_parameters_.assign(unit.begin(), unit.end());
        if (type == type_picture_parameters) picture_parameters_.assign(unit.begin(), unit.end());
    });
    if (sequence_parameters_.size() < 4 || picture_parameters_.empty()) fail("gives no parameters");
}

void H264Encoder::count(std::size_t picture_bytes)
{
    last_second_.push_back(picture_bytes);
    last_second_bytes_ += picture_bytes;
    if (last_second_.size() > static_cast<std::size_t>(pictures_per_s_)) {
        last_second_bytes_ -= last_second_.front();
        last_second_.pop_front();
    }
    busiest_second_bytes_ = std::max(busiest_second_bytes_, last_second_bytes_);
}

std::vector<std::uint8_t> H264Encoder::sequence_parameters() const
{
    std::vector<std::uint8_t> parameters = sequence_parameters_;
    const auto permits = [&](const Level &level) {
        return level.kbit_per_s * 1000 >= 8 * static_cast<long long>(busiest_second_bytes_);
    };
    const auto found = std::ranges::find_if(levels, permits);
    const std::uint8_t needed =
        found == std::end(levels) ? levels[std::size(levels) - 1].number : found->number;
    parameters[level_at] = std::max(parameters[level_at], needed);
    return parameters;
}

H264Encoder::Picture H264Encoder::encode(const Image &image)
{
    const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    std::uint8_t *blue = planes_.data() + pixels, *red = blue + pixels / 4;
    convert_brightness(image, planes_.data());
    convert_colour(image, blue, red);
    SSourcePicture source;
    std::memset(&source, 0, sizeof source);
    source.iColorFormat = videoFormatI420;
    source.iPicWidth = source.iStride[0] = width_;
    source.iPicHeight = height_;
    source.iStride[1] = source.iStride[2] = width_ / 2;
    source.pData[0] = planes_.data();
    source.pData[1] = blue;
    source.pData[2] = red;
    source.uiTimeStamp = pictures_++ * 1000 / pictures_per_s_; // ms
    SFrameBSInfo info;
    std::memset(&info, 0, sizeof info);
    if (encoder_->EncodeFrame(&source, &info) != cmResultSuccess) fail("cannot encode a picture");

    bytes_.clear();
    for_each_unit(info, [&](std::span<const std::uint8_t> unit) {
        // The parameter sets for the decoder are already in the index of the file and never change, so they
        // are not written again.
        const int type = unit[0] & type_mask;
        const auto is_same = [&](const auto &kept) { return std::ranges::equal(unit, kept); };
        if (type == type_sequence_parameters && is_same(sequence_parameters_)) return;
        if (type == type_picture_parameters && is_same(picture_parameters_)) return;
        for (int shift = 24; shift >= 0; shift -= 8)
            bytes_.push_back(static_cast<std::uint8_t>(unit.size() >> shift & 0xff));
        bytes_.insert(bytes_.end(), unit.begin(), unit.end());
    });
    if (info.eFrameType == videoFrameTypeSkip || bytes_.empty()) fail("dropped a picture");
    count(bytes_.size());
    return {bytes_, info.eFrameType == videoFrameTypeIDR};
}

void H264Encoder::fail(const std::string &what, const std::string &remedy) const
{
    const std::string said = said_;
    throw std::runtime_error("the library openh264 " + what + (said.empty() ? "" : " (" + said + ")") + "; " +
                             remedy);
}

} // namespace crn
