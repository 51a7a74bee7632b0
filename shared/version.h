/* This is the version of this release, by semantic versioning of everything on which others build: public
 * headers of core and host, command lines, and file formats (docs/CHANGELOG.md). The core's version decides
 * which recordings replay, and the protocol's version decides which programs may talk to each other; both are
 * separate from this version. */
#ifndef CRN_VERSION_H
#define CRN_VERSION_H

#define CRN_VERSION "0.1.0"

#endif
