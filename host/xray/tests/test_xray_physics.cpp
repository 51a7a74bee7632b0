// Tests the signal chain from path lengths to raw values. The test compares attenuation with the exponential
// function, noise with Poisson's law, edges with the formula of the MTF, and scatter with a measurement. The
// effects of one picture on the next are tested in test_xray_exposure.cpp.
#include "host/xray/blur.hpp"
#include "host/xray/detector.hpp"
#include "host/xray/scatter.hpp"
#include "host/xray/tests/xray_room.hpp"
#include "host/xray/xray.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>

using namespace crn;

namespace
{

double mean_photons(const XrayPicture &picture)
{
    double sum = 0.0, count = 0.0;
    for (std::uint32_t n : picture.photons) {
        sum += n;
        count += n > 0 ? 1.0 : 0.0;
    }
    return sum / count;
}

} // namespace

// The reference for the transmission is the exponential function of the same attenuation table, in double
// precision.
static void transmission_follows_beer_and_lambert(void **)
{
    const BeamTable beam = make_beam_table(75.0, 0.2);
    for (Material material : {Material::soft_tissue, Material::bone_cortical, Material::platinum})
        for (double path_mm : {0.0, 0.1, 1.0, 10.0, 100.0, 300.0}) {
            std::array<float, material_count> path{};
            path[static_cast<int>(material)] = static_cast<float>(path_mm * 1024.0);
            double expected = 0.0;
            for (int k = 0; k < beam_energy_count; ++k)
                expected +=
                    static_cast<double>(beam.share[k]) *
                    std::exp2(-path_mm * 1024.0 *
                              static_cast<double>(beam.log2_per_q10mm[static_cast<int>(material)][k]));
            const double share = transmission(beam, path);
            if (std::fabs(share - expected) > 1e-5 * expected + 1e-12)
                std::printf("# %g mm: %.9g, expected %.9g\n", path_mm, share, expected);
            assert_true(std::fabs(share - expected) <= 1e-5 * expected + 1e-12);
        }
}

// The variance of a Poisson distribution is equal to its mean. Over 262,144 pixels the mean may differ by
// five standard errors, and the variance by 2 %.
static void noise_has_the_poisson_mean_and_variance(void **)
{
    for (float expected : {0.4f, 3.0f, 11.0f, 13.0f, 60.0f, 400.0f, 20000.0f, 500000.0f}) {
        const int count = 1 << 18;
        const std::vector<float> row(512, expected);
        std::vector<std::uint32_t> photons(512);
        double sum = 0.0, square = 0.0;
        for (std::uint32_t first = 0; first < static_cast<std::uint32_t>(count); first += 512) {
            count_row(row.data(), 512, noise_key(99, 5), first, photons.data());
            for (std::uint32_t n : photons) {
                sum += n;
                square += (n - static_cast<double>(expected)) * (n - static_cast<double>(expected));
            }
        }
        const double mean = sum / count, variance = square / count;
        // Rounding to whole photons increases the variance by 1/12.
        const double wanted = expected < 12.0f ? expected : expected + 1.0 / 12.0;
        std::printf("# expected %g: mean %.4f, variance %.4f\n", static_cast<double>(expected), mean,
                    variance);
        assert_true(std::fabs(mean - expected) < 5.0 * std::sqrt(expected / count));
        assert_true(std::fabs(variance - wanted) < 0.02 * wanted);
    }
}

static void noise_of_neighbours_and_ticks_is_unrelated(void **)
{
    const std::vector<float> row(512, 100.0f);
    std::vector<std::uint32_t> a(512), b(512);
    double neighbours = 0.0, ticks = 0.0;
    for (std::uint32_t first = 0; first < 512u * 512u; first += 512) {
        count_row(row.data(), 512, noise_key(1, 10), first, a.data());
        count_row(row.data(), 512, noise_key(1, 11), first, b.data());
        for (int x = 0; x < 511; ++x) {
            neighbours += (a[x] - 100.0) * (a[x + 1] - 100.0);
            ticks += (a[x] - 100.0) * (b[x] - 100.0);
        }
    }
    std::printf("# correlation: neighbours %.5f, ticks %.5f\n", neighbours / 512 / 511 / 100,
                ticks / 512 / 511 / 100);
    assert_true(std::fabs(neighbours / 512 / 511 / 100) < 0.01); // 5 sigma of 261,632 products
    assert_true(std::fabs(ticks / 512 / 511 / 100) < 0.01);
}

// The test uses rendered pictures of 20 cm of tissue at three doses, with 2^20 pixels each. A noise-free
// picture with the same technique gives the mean of every pixel, so that the dimming by the oblique beam at
// the edges does not count as noise.
static void rendered_counts_have_variance_over_mean_of_one(void **)
{
    Room room(slab(0.20));
    for (double charge : {0.1, 1.0, 10.0}) {
        XraySettings settings = fixed(75.0, charge * 100.0, 10.0);
        settings.size = 1024;
        settings.beam.open_width_share = settings.beam.open_height_share = 1.0;
        const XrayPicture noisy = room.picture(settings);
        settings.beam.noise = false;
        const XrayPicture expected = room.picture(settings);
        double sum = 0.0, square = 0.0;
        for (std::size_t i = 0; i < noisy.photons.size(); ++i) {
            const double mean = expected.photons[i], off = noisy.photons[i] - mean;
            sum += mean;
            square += off * off;
        }
        std::printf("# %.1f mAs: mean %.1f, variance/mean %.4f over %zu pixels\n", charge,
                    sum / static_cast<double>(noisy.photons.size()), square / sum, noisy.photons.size());
        assert_true(std::fabs(square / sum - 1.0) < 0.02);
    }
}

// Photons, kerma and kerma-area product (KAP) must increase in proportion to the charge. The KAP must not
// depend on the distance from the source, and the kerma at the reference point must not depend on the
// distance of the detector.
static void dose_and_photons_come_from_the_same_charge(void **)
{
    Room room(slab(0.20));
    const XrayPicture one = room.picture(fixed(80.0, 50.0, 5.0)), two = room.picture(fixed(80.0, 100.0, 5.0));
    assert_true(std::fabs(two.photons_open / one.photons_open - 2.0) < 1e-12);
    assert_true(std::fabs(two.air_kerma_uGy / one.air_kerma_uGy - 2.0) < 1e-12);
    assert_true(std::fabs(two.kap_Gy_cm2 / one.kap_Gy_cm2 - 2.0) < 1e-12);
    // The program spekpy gives 24.60 uGy/mAs at 1 m behind 2.5 mm Al + 0.2 mm Cu; the reference point is 0.60
    // m from the focal spot.
    std::printf("# kerma %.3f uGy, KAP %.4g Gy cm2\n", one.air_kerma_uGy, one.kap_Gy_cm2);
    assert_true(std::fabs(one.air_kerma_uGy - 24.60 * 0.25 / 0.36) < 0.01 * one.air_kerma_uGy);
    XraySettings far = fixed(80.0, 50.0, 5.0);
    far.carm.source_detector_m = 1.20;
    far.carm.field_m *= 1.20 / 1.05; // the same cone
    const XrayPicture same = room.picture(far);
    assert_true(std::fabs(same.kap_Gy_cm2 / one.kap_Gy_cm2 - 1.0) < 1e-9);
    assert_true(std::fabs(same.air_kerma_uGy / one.air_kerma_uGy - 1.0) < 1e-12);
    // A field whose width is 97 % of 32 cm at a distance of 1.05 m is 17.74 cm wide at the reference point.
    const double side_cm = 32.0 * 496.0 / 512.0 * 0.60 / 1.05;
    std::printf("# area %.2f cm2, expected %.2f\n", one.kap_Gy_cm2 / one.air_kerma_uGy * 1e6,
                side_cm * side_cm);
    assert_true(std::fabs(one.kap_Gy_cm2 / one.air_kerma_uGy * 1e6 - side_cm * side_cm) <
                0.02 * side_cm * side_cm);
}

// Raw values must be linear in the number of quanta: mean raw = gain x mean photons, at doses that differ by
// a factor of 10.
static void raw_values_are_linear(void **)
{
    Room room(slab(0.25));
    for (double mA : {10.0, 100.0}) {
        XraySettings settings = fixed(75.0, mA, 5.0);
        settings.beam.dose_per_frame_nGy = 20.0;
        const XrayPicture picture = room.picture(settings);
        double raw = 0.0, photons = 0.0;
        for (int y = 100; y < 400; ++y)
            for (int x = 100; x < 400; ++x) {
                raw += picture.raw[y * 512 + x];
                photons += picture.photons[y * 512 + x];
            }
        const double gain = raw / photons;
        std::printf("# %.0f mA: mean raw %.1f, gain %.4f, stated %.4f\n", mA, raw / 9e4, gain,
                    picture.raw_per_photon);
        assert_true(std::fabs(gain / picture.raw_per_photon - 1.0) < 2e-3);
    }
}

namespace
{

// Measures the presampling MTF (before sampling by the pixels) by the slanted-edge method of ISO 12233 and
// IEC 62220-1. Each pixel of a row has its own distance from the slanted edge. All of them make one edge
// profile in steps of a tenth of a pixel, and the Fourier transform of its derivative is the MTF.
class SlantedEdge
{
  public:
    static constexpr int over = 10, reach = 24; // steps per pixel; pixels to both sides

    // `slope` is the number of columns by which the edge is displaced per row, and `middle` is the edge's
    // column in the middle row.
    SlantedEdge(const XrayPicture &picture, double slope, double middle)
    {
        std::vector<double> sum(2 * reach * over, 0.0), count(sum.size(), 0.0);
        const double half = 0.5 * picture.size, cosine = 1.0 / std::sqrt(1.0 + slope * slope);
        for (int y = picture.size / 4; y < picture.size * 3 / 4; ++y)
            for (int x = 0; x < picture.size; ++x) {
                const double across = (x + 0.5 - middle - slope * (y + 0.5 - half)) * cosine;
                const int step = static_cast<int>(std::floor((across + reach) * over));
                if (step < 0 || step >= 2 * reach * over) continue;
                sum[step] += picture.raw[static_cast<std::size_t>(y) * picture.size + x];
                count[step] += 1.0;
            }
        for (std::size_t i = 0; i < sum.size(); ++i) profile_.push_back(sum[i] / std::max(count[i], 1.0));
    }

    double mtf(double cycles_per_pixel) const
    {
        double real = 0.0, imaginary = 0.0, all = 0.0;
        for (std::size_t i = 0; i + 1 < profile_.size(); ++i) {
            const double spread = profile_[i + 1] - profile_[i];
            const double turn = 2.0 * 3.14159265358979 * cycles_per_pixel * static_cast<double>(i) / over;
            real += spread * std::cos(turn);
            imaginary += spread * std::sin(turn);
            all += spread;
        }
        const double half_step =
            3.14159265358979 * cycles_per_pixel / over; // difference of two means of a step each
        const double step_mtf = std::pow(std::sin(half_step) / half_step, 2.0);
        return std::sqrt(real * real + imaginary * imaginary) / std::fabs(all) / step_mtf;
    }

  private:
    std::vector<double> profile_;
};

// Makes a thin plate that covers the right half of the field; its edge is inclined to the columns by a slope
// of 1/16.
Body slanted_plate()
{
    Body body = box_body("plate", "steel", -1, {0.0, -0.3, -0.0002}, {0.3, 0.3, 0.0002});
    for (Eigen::Vector3i &vertex : body.vertices_um) vertex.x() += (vertex.y() + 8) / 16;
    return body;
}

} // namespace

// The MTF of a rendered edge must be the product of the MTF formulas of focal spot, pixel and scintillator.
// The MTF is tested up to 0.9 of half the sampling frequency, for three field sizes and both focal spots.
static void slanted_edge_has_the_stated_mtf(void **)
{
    Room room({{slanted_plate()}});
    struct Case {
        double field_m, focal_spot_mm;
        int size;
    };
    for (const Case &now : {Case{0.32, 0.4, 512}, Case{0.20, 0.4, 1024}, Case{0.15, 0.8, 1024}}) {
        XraySettings settings = fixed(75.0, 50.0, 5.0);
        settings.beam.fixed_technique->focal_spot_mm = now.focal_spot_mm;
        settings.beam.noise = settings.beam.scatter = false;
        settings.beam.dose_per_frame_nGy = 2000.0; // so that the open beam stays below raw_max
        settings.carm.field_m = now.field_m;
        settings.size = now.size;
        const XrayPicture picture = room.picture(settings);
        const BlurGeometry geometry{now.field_m * 1e3 / now.size, now.focal_spot_mm, 1.4};
        const SlantedEdge edge(picture, -1.0 / 16.0, 0.5 * now.size);
        for (double cycles : {0.05, 0.1, 0.2, 0.3, 0.4, 0.45}) {
            const double stated = mtf_of_system(geometry, cycles / geometry.pixel_mm),
                         seen = edge.mtf(cycles);
            std::printf("# field %.0f mm, focal spot %.1f mm, %.2f/mm: MTF %.4f, stated %.4f (%+.1f %%)\n",
                        now.field_m * 1e3, now.focal_spot_mm, cycles / geometry.pixel_mm, seen, stated,
                        (seen / stated - 1.0) * 100.0);
            // The tolerance of the test is 5 % of the MTF, or 0.005 where the MTF is nearly zero (the focal
            // spot of 0.8 mm at its first zero).
            assert_true(std::fabs(seen - stated) < std::max(0.05 * stated, 0.005));
        }
    }
}

namespace
{

// Returns the signal that a straight guidewire absorbs in each column, summed over rows around the middle.
// The sums of all columns together are a line spread function.
std::vector<double> line_of_a_wire(double focal_spot_mm)
{
    Room room(slab(0.05));
    XraySettings settings = fixed(75.0, 100.0, 10.0);
    settings.beam.fixed_technique->focal_spot_mm = focal_spot_mm;
    settings.beam.noise = settings.beam.scatter = false;
    settings.carm.field_m = 0.15;
    settings.size = 1024;
    WireFrame wire;
    for (int i = 0; i < 40; ++i)
        wire.nodes.push_back({Eigen::Vector3d(0.0003, 0.001 * i - 0.02, 0.0), 0.001 * i, 0.0004, 0.0});
    wire.tip_arc_m = {0.0};
    const RadiopaqueInstrument tool = guidewire_look();
    const XrayPicture without = room.picture(settings);
    XrayPicture with;
    room.xray->render(settings, {&tool, 1}, wire, 7, with);
    std::vector<double> line(1024, 0.0);
    for (std::size_t y = 412; y < 612; ++y)
        for (std::size_t x = 0; x < 1024; ++x)
            if (without.photons[y * 1024 + x] > 0) // not under the blades
                line[x] +=
                    1.0 - static_cast<double>(with.photons[y * 1024 + x]) / without.photons[y * 1024 + x];
    return line;
}

double spectrum_of(const std::vector<double> &line, double cycles_per_pixel)
{
    double real = 0.0, imaginary = 0.0;
    for (std::size_t x = 0; x < line.size(); ++x) {
        const double turn = 2.0 * 3.14159265358979 * cycles_per_pixel * static_cast<double>(x);
        real += line[x] * std::cos(turn);
        imaginary += line[x] * std::sin(turn);
    }
    return std::hypot(real, imaginary);
}

} // namespace

// The same guidewire is drawn with two focal spots. The spectra of the guidewire's shadow must differ by the
// ratio of the focal spots' MTFs, and the guidewire must absorb the same total signal. The MTF of each kernel
// must be within 0.01 of its curve.
static void focal_spot_blurs_tools_as_stated(void **)
{
    const std::vector<double> fine = line_of_a_wire(0.4), coarse = line_of_a_wire(0.8);
    const double pixel_mm = 150.0 / 1024.0;
    for (double cycles : {0.0, 0.1, 0.2, 0.3, 0.4}) {
        const double f = cycles / pixel_mm, stated = mtf_of_focal_spot({pixel_mm, 0.8, 1.4}, f) /
                                                     mtf_of_focal_spot({pixel_mm, 0.4, 1.4}, f);
        const double seen = spectrum_of(coarse, cycles) / spectrum_of(fine, cycles);
        std::printf("# %.2f/mm: ratio of spectra %.4f, stated %.4f\n", f, seen, stated);
        assert_true(std::fabs(seen - stated) < 0.03);
    }
}

// The scintillator blurs the noise, but focal spot and pixel do not. The noise of neighbouring pixels of the
// raw picture must therefore correlate as the scintillator's kernel predicts.
static void noise_has_the_texture_of_the_scintillator(void **)
{
    Room room(slab(0.20));
    XraySettings settings = fixed(75.0, 100.0, 5.0);
    settings.carm.field_m = 0.15;
    settings.beam.dose_per_frame_nGy = 100.0;
    const XrayPicture noisy = room.picture(settings);
    settings.beam.noise = false;
    const XrayPicture flat = room.picture(settings);
    double variance = 0.0, shifted[3] = {};
    for (int y = 50; y < 450; ++y)
        for (int x = 50; x < 450; ++x) {
            auto off = [&](int column) {
                return static_cast<double>(noisy.raw[y * 512 + column]) - flat.raw[y * 512 + column];
            };
            variance += off(x) * off(x);
            for (int k = 0; k < 3; ++k) shifted[k] += off(x) * off(x + k + 1);
        }
    const BlurKernel kernel = kernel_of_scintillator(settings.carm.field_m * 1e3 / 512.0);
    auto tap = [&](int k) {
        k = std::abs(k);
        return k <= kernel.radius ? static_cast<double>(kernel.tap[k]) : 0.0;
    };
    auto overlap = [&](int shift) {
        double sum = 0.0;
        for (int k = -20; k <= 20; ++k) sum += tap(k) * tap(k + shift);
        return sum;
    };
    for (int k = 0; k < 3; ++k) {
        std::printf("# neighbour %d: correlation %.3f, expected %.3f\n", k + 1, shifted[k] / variance,
                    overlap(k + 1) / overlap(0));
        assert_true(std::fabs(shifted[k] / variance - overlap(k + 1) / overlap(0)) < 0.02);
    }
}

namespace
{

// Returns the ratio of scattered to primary signal in the middle of a field, in front of the grid. The slab
// covers the whole detector; the detector's pixels are square.
double scatter_to_primary(double tissue_cm, double kV, double width_cm, double height_cm)
{
    const Spectrum open = tube_spectrum(kV, 0.2), left = behind(open, Material::soft_tissue, tissue_cm);
    double primary = 0.0, all = 0.0;
    for (int i = 0; i < energy_count; ++i) {
        primary += left[i] * scintillator_absorption(i) * energy_keV(i);
        all += open[i] * scintillator_absorption(i) * energy_keV(i);
    }
    const int size = 512;
    const double pixel_mm = 450.0 / size;
    const std::vector<float> picture(static_cast<std::size_t>(size) * size,
                                     static_cast<float>(primary / all));
    std::vector<OpenColumns> field(size);
    const int half_width = static_cast<int>(width_cm * 5.0 / pixel_mm + 0.5);
    for (int y = 0; y < size; ++y)
        if (std::fabs(y + 0.5 - 0.5 * size) * pixel_mm < height_cm * 5.0)
            field[y] = {size / 2 - half_width, size / 2 + half_width};
    const std::vector<float> scattered =
        scatter_part(coarse_sums(picture, size, field), size / coarse_cell, pixel_mm * coarse_cell);
    const int cells = size / coarse_cell;
    return static_cast<double>(scattered[(cells / 2) * cells + cells / 2]) * all / primary;
}

} // namespace

// Altunbas et al. 2016 measured scatter at 125 kV in a field of 40 x 30 cm behind 30 cm of acrylic, which has
// as many electrons as 33 cm of tissue. Altunbas measured a ratio of scattered to primary photons of 4.51
// without a grid, and of 1.28 behind the grid. Textbooks (Bushberg et al., chapter on scatter) give a ratio
// of about 3 for 20 cm of tissue in a field of 30 x 30 cm; the ratio increases with thickness and field.
static void scatter_agrees_with_a_measurement_and_grows_with_field_and_thickness(void **)
{
    const double measured = scatter_to_primary(33.0, 125.0, 40.0, 30.0);
    std::printf("# 33 cm in 40 x 30 cm: %.2f, measured 4.51; behind the grid %.2f, measured 1.28\n", measured,
                measured * static_cast<double>(grid_scatter_to_primary));
    assert_true(std::fabs(measured - 4.51) < 0.1 * 4.51);
    assert_true(std::fabs(measured * static_cast<double>(grid_scatter_to_primary) - 1.28) < 0.1 * 1.28);
    const double usual = scatter_to_primary(20.0, 80.0, 30.0, 30.0);
    std::printf("# 20 cm in 30 x 30 cm: %.2f\n", usual);
    assert_true(usual > 2.4 && usual < 3.6);
    double last = 0.0;
    for (double field_cm : {5.0, 10.0, 15.0, 20.0, 25.0, 30.0}) {
        const double ratio = scatter_to_primary(20.0, 80.0, field_cm, field_cm);
        std::printf("# 20 cm in %.0f x %.0f cm: %.2f\n", field_cm, field_cm, ratio);
        assert_true(ratio > last);
        last = ratio;
    }
    assert_true(scatter_to_primary(30.0, 80.0, 20.0, 20.0) >
                1.3 * scatter_to_primary(20.0, 80.0, 20.0, 20.0));
}

// Digital subtraction subtracts the logarithms of two raw pictures that have the same fixed technique. In one
// of the two pictures the beam also passes 4 mm of undiluted contrast medium. The logarithms of the two
// pictures must differ by the attenuation that the beam's table gives for contrast medium behind the same
// patient. Beside the contrast medium the two pictures must be equal to the last bit.
static void logarithms_of_raw_values_subtract_exactly(void **)
{
    const Body trunk = box_body("trunk", "soft_tissue", -1, {-0.5, -0.5, -0.1}, {0.5, 0.5, 0.1});
    const Body vessel = box_body("vessel", "contrast", 0, {-0.01, -0.05, -0.002}, {0.01, 0.05, 0.002});
    Room empty({{trunk}}), filled({{trunk, vessel}});
    XraySettings settings = fixed(70.0, 500.0, 60.0);
    settings.beam.noise = settings.beam.scatter = false;
    settings.beam.mode = ExposureMode::dsa;
    settings.beam.dose_per_frame_nGy = 300.0;
    const XrayPicture mask = empty.picture(settings), live = filled.picture(settings);
    const std::size_t middle = 256 * 512 + 256, beside = 256 * 512 + 100;
    const BeamTable beam = make_beam_table(70.0, 0.2);
    std::array<float, material_count> without{}, with{};
    without[static_cast<int>(Material::soft_tissue)] = 200.0f * 1024.0f;
    with[static_cast<int>(Material::soft_tissue)] = 196.0f * 1024.0f;
    with[static_cast<int>(Material::iohexol_350)] = 4.0f * 1024.0f;
    const double expected =
        std::log(static_cast<double>(transmission(beam, without) / transmission(beam, with)));
    const double seen = std::log(static_cast<double>(mask.raw[middle]) / live.raw[middle]);
    std::printf("# raw %d and %d: difference of logarithms %.4f, expected %.4f\n", mask.raw[middle],
                live.raw[middle], seen, expected);
    assert_true(mask.raw[middle] < raw_max);
    assert_true(std::fabs(seen - expected) < 0.005 * expected); // half a raw unit in the darker one
    assert_int_equal(mask.raw[beside], live.raw[beside]);
}

// By PS3.3 C.11.2.1.2 values below level - window/2 are black, values above level + window/2 are white, and
// grey is linear between them.
static void window_and_level_are_those_of_dicom(void **)
{
    Room room(slab(0.2));
    XraySettings settings;
    settings.size = 256;
    settings.display.window = 401.0;
    settings.display.level = 2300.0;
    const XrayPicture picture = room.picture(settings);
    int between = 0;
    for (std::size_t i = 0; i < picture.grey.size(); ++i) {
        if (picture.photons[i] == 0) continue;
        const double expected = std::clamp(((picture.shown[i] - 2299.5) / 400.0 + 0.5) * 255.0, 0.0, 255.0);
        assert_true(std::fabs(picture.grey[i] - expected) <= 0.51);
        between += expected > 0.0 && expected < 255.0;
    }
    assert_true(between > 1000);
}

// The grey of the picture must not depend on the dose: a tenth of the dose gives the same mean grey value,
// with more noise.
static void photons_are_fewer_at_a_lower_dose_and_the_grey_is_the_same(void **)
{
    Room room(slab(0.2));
    XraySettings settings;
    settings.beam.fixed_technique = XrayTechnique{75.0, 100.0, 10.0, 0.3, 0.4};
    const XrayPicture much = room.picture(settings);
    settings.beam.fixed_technique->tube_current_mA = 10.0;
    const XrayPicture little = room.picture(settings);
    assert_true(std::fabs(mean_photons(much) / mean_photons(little) - 10.0) < 0.1);
    double difference = 0.0;
    for (std::size_t i = 0; i < much.grey.size(); ++i)
        difference += much.grey[i] - static_cast<double>(little.grey[i]);
    assert_true(std::fabs(difference / static_cast<double>(much.grey.size())) < 2.0);
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(transmission_follows_beer_and_lambert),
        cmocka_unit_test(noise_has_the_poisson_mean_and_variance),
        cmocka_unit_test(noise_of_neighbours_and_ticks_is_unrelated),
        cmocka_unit_test(rendered_counts_have_variance_over_mean_of_one),
        cmocka_unit_test(dose_and_photons_come_from_the_same_charge),
        cmocka_unit_test(raw_values_are_linear),
        cmocka_unit_test(slanted_edge_has_the_stated_mtf),
        cmocka_unit_test(focal_spot_blurs_tools_as_stated),
        cmocka_unit_test(noise_has_the_texture_of_the_scintillator),
        cmocka_unit_test(scatter_agrees_with_a_measurement_and_grows_with_field_and_thickness),
        cmocka_unit_test(logarithms_of_raw_values_subtract_exactly),
        cmocka_unit_test(window_and_level_are_those_of_dicom),
        cmocka_unit_test(photons_are_fewer_at_a_lower_dose_and_the_grey_is_the_same),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
