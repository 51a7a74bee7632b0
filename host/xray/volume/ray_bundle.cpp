// The innermost loop of the ray caster, once in plain C++ and once for AVX2.
#include "host/xray/volume/ray_bundle.hpp"
#include <algorithm>
#ifdef CRN_HAS_AVX2
#include <immintrin.h>
#endif

namespace crn
{
namespace
{

constexpr int fraction_bits = 7, one = 1 << fraction_bits;
constexpr int sum_shift = 2 * fraction_bits - sum_bits;
[[maybe_unused]] constexpr int window_voxels = 8; // one load of 16 bytes

void cast_ray(const SlabOfSlices &slab, RayBundle &bundle, int lane)
{
    const auto at = [&](std::int32_t start, std::int32_t step) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(start) +
                                         static_cast<std::uint32_t>(step) *
                                             static_cast<std::uint32_t>(slab.first));
    };
    std::int32_t q = at(bundle.q[lane], bundle.step_q[lane]), r = at(bundle.r[lane], bundle.step_r[lane]);
    const std::uint16_t *slice = slab.voxels + std::int64_t{slab.slice_stride} * slab.first;
    for (int k = slab.first; k < slab.end; ++k, slice += slab.slice_stride) {
        std::int32_t value = 0;
        if (q >= 0 && r >= 0 && q < slab.q_limit && r < slab.r_limit) {
            const std::uint16_t *near = slice + (r >> 16) * slab.row_stride + (q >> 16),
                                *far = near + slab.row_stride;
            const int along_q = (q >> (16 - fraction_bits)) & (one - 1),
                      along_r = (r >> (16 - fraction_bits)) & (one - 1);
            const int far_1 = along_q * along_r, far_0 = (one - along_q) * along_r;
            const int near_1 = along_q * one - far_1, near_0 = (one - along_q) * one - far_0;
            value = (near[0] * near_0 + near[1] * near_1 + far[0] * far_0 + far[1] * far_1) >> sum_shift;
        }
        bundle.all[lane] += static_cast<std::uint32_t>(value);
        for (int knot = 0; knot < knot_count; ++knot)
            bundle.over[knot][lane] += static_cast<std::uint32_t>(std::max(value, slab.knots[knot]));
        q += bundle.step_q[lane];
        r += bundle.step_r[lane];
    }
}

} // namespace

void cast_slab_plain(const SlabOfSlices &slab, RayBundle *bundles, int count)
{
    for (int i = 0; i < count; ++i)
        for (int lane = 0; lane < lane_count; ++lane) cast_ray(slab, bundles[i], lane);
}

#ifdef CRN_HAS_AVX2
namespace
{

CRN_AVX2_BEGIN

inline __m256i load(const void *from)
{
    return _mm256_load_si256(static_cast<const __m256i *>(from));
}

inline void store(void *to, __m256i value)
{
    _mm256_store_si256(static_cast<__m256i *>(to), value);
}

// Weights of the pair of voxels along q in the low and high half of each lane: one - fraction and fraction.
inline __m256i pair_of(__m256i fraction)
{
    const __m256i high = _mm256_slli_epi32(fraction, 16);
    return _mm256_add_epi32(_mm256_set1_epi32(one), _mm256_sub_epi32(high, fraction));
}

// The pairs of neighbours along q of eight rays, in the row of each ray and in the next row.
struct Pairs {
    __m256i near, far;
};

inline __m256i load_halves(const std::uint16_t *low, const std::uint16_t *high)
{
    return _mm256_inserti128_si256(
        _mm256_castsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i *>(low))),
        _mm_loadu_si128(reinterpret_cast<const __m128i *>(high)), 1);
}

// Most often the voxels of four neighbouring rays lie within eight voxels of two neighbouring rows: one load
// and one shuffle for each row then replace four separate reads. `base` is the lowest place of each half of
// four rays; `along_q` and `along_r` are the distances of each ray from it.
inline Pairs shuffled(const std::uint16_t *slice, std::int32_t row_stride, __m256i base, __m256i along_q,
                      __m256i along_r)
{
    const std::uint16_t *low = slice + _mm256_cvtsi256_si32(base);
    const std::uint16_t *high = slice + _mm256_extract_epi32(base, 4);
    const __m256i bytes = _mm256_add_epi32(_mm256_mullo_epi32(along_q, _mm256_set1_epi32(0x02020202)),
                                           _mm256_set1_epi32(0x03020100));
    const __m256i is_next = _mm256_sub_epi32(_mm256_setzero_si256(), along_r);
    const __m256i row_0 = _mm256_shuffle_epi8(load_halves(low, high), bytes);
    const __m256i row_1 = _mm256_shuffle_epi8(load_halves(low + row_stride, high + row_stride), bytes);
    const __m256i row_2 =
        _mm256_shuffle_epi8(load_halves(low + 2 * row_stride, high + 2 * row_stride), bytes);
    return {_mm256_blendv_epi8(row_0, row_1, is_next), _mm256_blendv_epi8(row_1, row_2, is_next)};
}

inline Pairs gathered(const std::uint16_t *slice, std::int32_t row_stride, __m256i place, __m256i wanted)
{
    const __m256i zero = _mm256_setzero_si256();
    return {_mm256_mask_i32gather_epi32(zero, reinterpret_cast<const int *>(slice), place, wanted, 2),
            _mm256_mask_i32gather_epi32(zero, reinterpret_cast<const int *>(slice + row_stride), place,
                                        wanted, 2)};
}

// Tells which rays are within the limits.
inline __m256i within(const SlabOfSlices &slab, __m256i q, __m256i r)
{
    const __m256i zero = _mm256_setzero_si256();
    const __m256i outside =
        _mm256_or_si256(_mm256_or_si256(_mm256_cmpgt_epi32(zero, q), _mm256_cmpgt_epi32(zero, r)),
                        _mm256_or_si256(_mm256_cmpgt_epi32(q, _mm256_set1_epi32(slab.q_limit - 1)),
                                        _mm256_cmpgt_epi32(r, _mm256_set1_epi32(slab.r_limit - 1))));
    return _mm256_xor_si256(outside, _mm256_set1_epi32(-1));
}

// The rays of a half are in order, so that the lowest number is that of the first or of the last ray.
inline __m256i lowest_of_half(__m256i value)
{
    return _mm256_min_epi32(_mm256_shuffle_epi32(value, 0x00), _mm256_shuffle_epi32(value, 0xff));
}

template <bool is_inside>
inline Pairs read_pairs(const SlabOfSlices &slab, const std::uint16_t *slice, __m256i q, __m256i r)
{
    __m256i wanted = _mm256_set1_epi32(-1);
    if constexpr (!is_inside) {
        wanted = within(slab, q, r);
        if (_mm256_testz_si256(wanted, wanted)) return {_mm256_setzero_si256(), _mm256_setzero_si256()};
    }
    const __m256i at_q = _mm256_srli_epi32(q, 16), at_r = _mm256_srli_epi32(r, 16);
    const __m256i row = _mm256_set1_epi32(slab.row_stride);
    const __m256i first_q = lowest_of_half(at_q), first_r = lowest_of_half(at_r);
    const __m256i along_q = _mm256_sub_epi32(at_q, first_q), along_r = _mm256_sub_epi32(at_r, first_r);
    __m256i is_far = _mm256_or_si256(_mm256_cmpgt_epi32(along_q, _mm256_set1_epi32(window_voxels - 2)),
                                     _mm256_cmpgt_epi32(along_r, _mm256_set1_epi32(1)));
    if constexpr (!is_inside)
        is_far = _mm256_or_si256(is_far, _mm256_xor_si256(wanted, _mm256_set1_epi32(-1)));
    if (_mm256_testz_si256(is_far, is_far))
        return shuffled(slice, slab.row_stride, _mm256_add_epi32(_mm256_mullo_epi32(first_r, row), first_q),
                        along_q, along_r);
    const __m256i place = _mm256_add_epi32(_mm256_mullo_epi32(at_r, row), at_q);
    return gathered(slice, slab.row_stride, _mm256_and_si256(place, wanted), wanted);
}

template <bool is_inside> void cast_bundle(const SlabOfSlices &slab, RayBundle &bundle)
{
    const __m256i step_q = load(bundle.step_q), step_r = load(bundle.step_r);
    const __m256i first = _mm256_set1_epi32(slab.first), mask = _mm256_set1_epi32(one - 1);
    __m256i q = _mm256_add_epi32(load(bundle.q), _mm256_mullo_epi32(step_q, first));
    __m256i r = _mm256_add_epi32(load(bundle.r), _mm256_mullo_epi32(step_r, first));
    __m256i all = load(bundle.all), over[knot_count], knots[knot_count];
    for (int knot = 0; knot < knot_count; ++knot) {
        over[knot] = load(bundle.over[knot]);
        knots[knot] = _mm256_set1_epi32(slab.knots[knot]);
    }
    const std::uint16_t *slice = slab.voxels + std::int64_t{slab.slice_stride} * slab.first;
    for (int k = slab.first; k < slab.end; ++k, slice += slab.slice_stride) {
        const Pairs pairs = read_pairs<is_inside>(slab, slice, q, r);
        const __m256i along_q = _mm256_and_si256(_mm256_srli_epi32(q, 16 - fraction_bits), mask);
        __m256i along_r = _mm256_and_si256(_mm256_srli_epi32(r, 16 - fraction_bits), mask);
        along_r = _mm256_or_si256(along_r, _mm256_slli_epi32(along_r, 16));
        const __m256i weights = pair_of(along_q);
        const __m256i far = _mm256_mullo_epi16(weights, along_r);
        const __m256i near = _mm256_sub_epi16(_mm256_slli_epi16(weights, fraction_bits), far);
        const __m256i value = _mm256_srli_epi32(
            _mm256_add_epi32(_mm256_madd_epi16(pairs.near, near), _mm256_madd_epi16(pairs.far, far)),
            sum_shift);
        all = _mm256_add_epi32(all, value);
        for (int knot = 0; knot < knot_count; ++knot)
            over[knot] = _mm256_add_epi32(over[knot], _mm256_max_epi32(value, knots[knot]));
        q = _mm256_add_epi32(q, step_q);
        r = _mm256_add_epi32(r, step_r);
    }
    store(bundle.all, all);
    for (int knot = 0; knot < knot_count; ++knot) store(bundle.over[knot], over[knot]);
}

void cast_slab_avx2(const SlabOfSlices &slab, RayBundle *bundles, int count)
{
    for (int i = 0; i < count; ++i) {
        if (slab.is_inside)
            cast_bundle<true>(slab, bundles[i]);
        else
            cast_bundle<false>(slab, bundles[i]);
    }
}

CRN_AVX2_END

} // namespace
#endif

CastSlab choose_cast_slab()
{
#ifdef CRN_HAS_AVX2
    if (__builtin_cpu_supports("avx2")) return cast_slab_avx2;
#endif
    return cast_slab_plain;
}

} // namespace crn
