// Computes with eight numbers at a time, in the vector types that gcc and clang provide. Code with these
// vector types is compiled twice, with and without AVX2. The results are equal on every processor; processors
// with vectors of eight numbers compute them faster than others. The code does not use fused multiply-add,
// because this operation rounds differently.
#pragma once
#include <cstdint>

namespace crn
{

inline constexpr int lane_count = 8;
typedef std::int32_t Lanes_i __attribute__((vector_size(32)));
typedef std::uint32_t Lanes_u __attribute__((vector_size(32)));
typedef float Lanes_f __attribute__((vector_size(32)));
typedef std::int32_t Lanes_i_anywhere __attribute__((vector_size(32), aligned(4), may_alias));

typedef float Lanes_f_anywhere __attribute__((vector_size(32), aligned(4), may_alias));

// Four numbers at a time, for the coordinates of a point.
typedef std::int32_t Four_i __attribute__((vector_size(16)));
typedef std::int32_t Four_i_anywhere __attribute__((vector_size(16), aligned(4), may_alias));
typedef std::uint32_t Four_u __attribute__((vector_size(16)));
typedef float Four_f __attribute__((vector_size(16)));

inline constexpr Lanes_i lane_index = {0, 1, 2, 3, 4, 5, 6, 7};

#if defined(__x86_64__)
#define CRN_HAS_AVX2 1
// Functions between these two macros may use AVX2, and may be called only if the processor has AVX2.
#if defined(__clang__)
#define CRN_AVX2_BEGIN _Pragma("clang attribute push(__attribute__((target(\"avx2\"))), apply_to = function)")
#define CRN_AVX2_END _Pragma("clang attribute pop")
#else
#define CRN_AVX2_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2\")")
#define CRN_AVX2_END _Pragma("GCC pop_options")
#endif
#endif

// The macro CRN_WIDE marks a function whose loops the compiler vectorises. The compiler makes a second
// version of the function for AVX2; at its start the program chooses the version that the processor can
// execute. With sanitizers the function is compiled only once, because the choice between the versions would
// be made before the sanitizers are ready.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define CRN_WIDE
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__x86_64__)
#define CRN_WIDE
#endif
#ifndef CRN_WIDE
#define CRN_WIDE __attribute__((target_clones("avx2", "default")))
#endif

} // namespace crn
