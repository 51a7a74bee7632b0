/* This header sets the length of long runs in tests. Builds with sanitizers compute only a tenth of a long
 * run. Sanitizers make a run five times as long, and a tenth of the run is enough for them to find errors.
 * Only the build without sanitizers checks the whole run. C11 and C++. */
#ifndef CRN_REFERENCE_LONG_RUN_H
#define CRN_REFERENCE_LONG_RUN_H

// The compiler gcc reports a sanitizer by a macro, and clang reports it by __has_feature.
#if defined __SANITIZE_ADDRESS__
#define REFERENCE_SANITIZED
#elif defined __has_feature
#if __has_feature(address_sanitizer)
#define REFERENCE_SANITIZED
#endif
#endif

#ifdef REFERENCE_SANITIZED
#define REFERENCE_RUN(whole) ((whole) / 10)
#else
#define REFERENCE_RUN(whole) (whole)
#endif

#endif
