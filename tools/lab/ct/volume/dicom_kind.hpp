// What a DICOM file says of itself, beside its grid: is it a slice of a CT, and can its values be trusted? No
// message repeats a name, a date, an identifier or any other text of the file.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace crn::ct
{

// Returns the text of an element, such as "0008|0060", without the blanks and zeros at its end; empty if it
// is missing.
using DicomTag = std::function<std::string(const char *element)>;

// Throws Fault if the file is no slice of a CT: another modality, a photograph of a screen, several frames, a
// scout, or writing within the picture, which may be a name.
void check_dicom_kind(const DicomTag &tag, const std::string &file);

// Throws Fault unless a slice states its position, its two directions and the distance of its pixels, as
// numbers that can be. GDCM takes 0, the patient's axes or 1 mm for what it cannot read.
void check_dicom_places(const DicomTag &tag, const std::string &file);

// Returns how many bytes the pixels of a slice need where they are not packed.
std::uint64_t dicom_pixel_bytes(const DicomTag &tag);

// Returns what a person must check in a slice: values that may not be HU, losses of compression, an unusual
// position of the patient.
std::vector<std::string> dicom_doubts(const DicomTag &tag);

// Must be the same in all slices of a series: patient, study, frame of reference. Returns the name of what
// `a` and `b` differ in; empty: nothing.
struct DicomOwner {
    std::string patient, birth, study, frame;
};
DicomOwner dicom_owner(const DicomTag &tag);
std::string difference_of(const DicomOwner &a, const DicomOwner &b);

} // namespace crn::ct
