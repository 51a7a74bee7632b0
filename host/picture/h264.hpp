// Encodes pictures as H.264 with the library openh264, in the profile High, at one constant quality. The
// encoder uses one thread, so equal pictures always give equal bytes. Only h264.cpp includes the library's
// headers.
#pragma once
#include "host/picture/picture.hpp"
#include <deque>
#include <memory>
#include <span>

class ISVCEncoder;

namespace crn
{

class H264Encoder
{
  public:
    // The library openh264 accepts at most 9,437,184 pixels per picture; the constant is the square root of
    // this number.
    static constexpr int edge_max = 3072;
    // Every two seconds the film has a key picture, at which a player can begin to play.
    static constexpr int seconds_between_keys = 2;

    // Width and height of the pictures must be even, and from 16 to edge_max pixels. The constructor and
    // encode() throw std::runtime_error with the message of the library openh264.
    H264Encoder(int width, int height, int pictures_per_s);
    ~H264Encoder();
    H264Encoder(const H264Encoder &) = delete;
    H264Encoder &operator=(const H264Encoder &) = delete;

    struct Picture {
        std::span<const std::uint8_t> bytes; // NAL units, each behind its length (4 bytes, big end first)
        bool is_key;                         // decoding can begin here
    };
    // RGB of the given size. The returned bytes of the H.264 stream are valid until the next call.
    Picture encode(const Image &image);
    // The next two functions return the two parameter sets (SPS and PPS) that a decoder needs before the
    // first picture, without start codes. After the last picture, the level in the sequence parameters
    // permits the bit rate of the film's busiest second.
    std::vector<std::uint8_t> sequence_parameters() const;
    const std::vector<std::uint8_t> &picture_parameters() const { return picture_parameters_; }

  private:
    struct End {
        void operator()(ISVCEncoder *encoder) const;
    };
    static void keep_message(void *self, int level, const char *text);
    void start();
    void silence();
    void count(std::size_t picture_bytes);
    [[noreturn]] void fail(const std::string &what,
                           const std::string &remedy = "write pictures instead (--png)") const;

    int width_, height_, pictures_per_s_;
    long long pictures_ = 0;
    std::deque<std::size_t> last_second_; // bytes of each picture
    std::size_t last_second_bytes_ = 0, busiest_second_bytes_ = 0;
    char said_[160] = {}; // by the library: its last error
    std::vector<std::uint8_t> planes_, bytes_, sequence_parameters_, picture_parameters_;
    std::unique_ptr<ISVCEncoder, End> encoder_;
};

} // namespace crn
