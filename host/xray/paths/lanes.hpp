// Computes with eight numbers at a time, by the vector types that gcc and clang share. Code is compiled
// twice: the bits are the same on any processor, and it runs faster where vectors of that width exist. There
// is no fused multiply-add, so nothing rounds differently.
#pragma once
#include <cstdint>

namespace crn
{

inline constexpr int lane_count = 8;
typedef std::int32_t Lanes_i __attribute__((vector_size(32)));
typedef float Lanes_f __attribute__((vector_size(32)));
typedef std::int32_t Lanes_i_anywhere __attribute__((vector_size(32), aligned(4), may_alias));

inline constexpr Lanes_i lane_index = {0, 1, 2, 3, 4, 5, 6, 7};

#if defined(__x86_64__)
#define CRN_HAS_AVX2 1
// Functions between the two macros may use AVX2; call them only where the processor has it.
#if defined(__clang__)
#define CRN_AVX2_BEGIN _Pragma("clang attribute push(__attribute__((target(\"avx2\"))), apply_to = function)")
#define CRN_AVX2_END _Pragma("clang attribute pop")
#else
#define CRN_AVX2_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2\")")
#define CRN_AVX2_END _Pragma("GCC pop_options")
#endif
#endif

// CRN_WIDE marks a function of plain loops that the compiler vectorises. It is compiled twice, the second
// time for AVX2, and the processor's version is chosen when the program starts. Under sanitizers it is
// compiled once, because that choice runs before they are ready.
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
