/* The macro CRN_VERSION is the version of the release. The release version follows semantic versioning of
 * everything on which others build: public headers of core and host, command lines, and file formats
 * (docs/CHANGELOG.md). The core's own version decides which recordings replay, and the protocol's own version
 * decides which programs may talk to each other; the release version decides neither. */
#ifndef CRN_VERSION_H
#define CRN_VERSION_H

#define CRN_VERSION "0.1.0"
#define CRN_VERSION_DATE "2026-11-24" /* of the last change of the command lines; man pages show it */

#endif
