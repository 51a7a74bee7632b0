/* The version of this release, by semantic versioning of what others build on: public headers of core and
 * host, command lines, file formats (docs/CHANGELOG.md). Which recordings replay is the core's version, and
 * who may talk to whom the protocol's: both are apart from this one. */
#ifndef CRN_VERSION_H
#define CRN_VERSION_H

#define CRN_VERSION "0.1.0"

#endif
