/* How much of a long run a test does: all of it, or a tenth under the sanitizers, which take five times as
 * long and see in a tenth what they look for. What the test claims of the whole run is held by the build
 * without them. C11 and C++. */
#ifndef CRN_REFERENCE_LONG_RUN_H
#define CRN_REFERENCE_LONG_RUN_H

// gcc tells by a macro, clang by a feature.
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
