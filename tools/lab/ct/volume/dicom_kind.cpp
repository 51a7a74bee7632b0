#include "tools/lab/ct/volume/dicom_kind.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace crn::ct
{

namespace
{

// The text of a file may be anything, so only a short code of capitals and digits is repeated in a message.
std::string code_of(const std::string &text)
{
    const bool is_code = !text.empty() && text.size() <= 4 &&
                         std::all_of(text.begin(), text.end(),
                                     [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); });
    return is_code ? "'" + text + "'" : "of another kind";
}

bool has(const std::string &text, const char *part)
{
    return text.find(part) != std::string::npos;
}

double number_of(const std::string &text)
{
    return std::strtod(text.c_str(), nullptr);
}

// Returns the numbers of a text such as "1\\0\\0"; none if any part is no finite number.
std::vector<double> numbers_of(const std::string &text)
{
    std::vector<double> numbers;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find('\\', at), text.size());
        const std::string word = text.substr(at, end - at);
        char *rest = nullptr;
        numbers.push_back(std::strtod(word.c_str(), &rest));
        if (rest == word.c_str() || std::string(rest).find_first_not_of(' ') != std::string::npos ||
            !std::isfinite(numbers.back()))
            return {};
        at = end + 1;
    }
    return numbers;
}

void check_form(const DicomTag &tag, const std::string &file)
{
    const std::string frames = tag("0028|0008"), colours = tag("0028|0004"), unit = tag("0028|1054");
    if (number_of(frames) > 1)
        throw Fault(file +
                    ": has several frames in one file (0028,0008): export the series as CT images, one file "
                    "per slice");
    if (!colours.empty() && colours != "MONOCHROME2")
        throw Fault(file +
                    ": its values are colours or inverted grey (0028,0004), not HU: export the original CT "
                    "images");
    if (!unit.empty() && unit != "HU" && unit != "US")
        throw Fault(
            file +
            ": its values are not in HU (0028,1054): export the series of CT images, not a map made of "
            "it");
    if (number_of(tag("0028|0002")) > 1)
        throw Fault(file +
                    ": has several values per pixel (0028,0002), not HU: export the original CT images");
    for (const char *scale : {"0028|1052", "0028|1053"})
        if (const std::string text = tag(scale); !text.empty() && numbers_of(text).size() != 1)
            throw Fault(file + ": its rescale to HU (0028,1052 and 0028,1053) is no number: export it again");
    if (!tag("0028|1053").empty() && number_of(tag("0028|1053")) == 0.0)
        throw Fault(file +
                    ": its slope of rescale (0028,1053) is 0, so that all values are equal: export it again");
}

} // namespace

void check_dicom_kind(const DicomTag &tag, const std::string &file)
{
    const std::string kind = tag("0008|0016"), modality = tag("0008|0060"), type = tag("0008|0008");
    if (has(tag("0028|0301"), "YES"))
        throw Fault(file +
                    ": has writing burned into its picture (0028,0301), which may name the patient: give the "
                    "original CT images");
    if (kind.rfind("1.2.840.10008.5.1.4.1.1.7", 0) == 0)
        throw Fault(
            file +
            ": is a secondary capture (0008,0016), the picture of a screen: give the original CT images");
    if (!modality.empty() && modality != "CT")
        throw Fault(file + ": its modality (0008,0060) is " + code_of(modality) +
                    ", no CT: give the series of a CT");
    if (has(type, "LOCALIZER"))
        throw Fault(file + ": is a localizer (0008,0008), no slice: take it out of the folder");
    check_form(tag, file);
}

std::vector<std::string> dicom_doubts(const DicomTag &tag)
{
    std::vector<std::string> doubts;
    if (tag("0008|0060").empty()) doubts.push_back("says no modality (0008,0060): is it a CT?");
    if (tag("0028|1052").empty() || tag("0028|1053").empty())
        doubts.push_back(
            "says no rescale to HU (0028,1052 and 0028,1053): its stored values are taken as HU");
    if (tag("0028|1054") == "US")
        doubts.push_back("says that its unit is unknown (0028,1054): it is taken as HU");
    if (has(tag("0028|2110"), "01"))
        doubts.push_back(
            "was compressed with loss (0028,2110): edges of vessels may have moved, and HU differ");
    const std::string type = tag("0008|0008"), lies = tag("0018|5100");
    if (has(type, "MIP") || has(type, "PROJECTION"))
        doubts.push_back("is a projection (0008,0008), such as a MIP: vessels look too long and too bright");
    if (std::abs(number_of(tag("0018|1120"))) > 0.1)
        doubts.push_back(
            "says that the gantry was tilted (0018,1120), its slices say that it was not: compare lengths "
            "and angles");
    if (lies == "HFP" || lies == "FFP" || lies == "HFDR" || lies == "HFDL" || lies == "FFDR" ||
        lies == "FFDL")
        doubts.push_back(
            "shows a patient who did not lie on the back (0018,5100): organs and vessels lie differently");
    return doubts;
}

void check_dicom_places(const DicomTag &tag, const std::string &file)
{
    const std::string again = ": export the series again as CT images";
    if (numbers_of(tag("0020|0032")).size() != 3)
        throw Fault(file + ": says no position of its slice (0020,0032), so that places in it are unknown" +
                    again);
    const std::vector<double> axes = numbers_of(tag("0020|0037")), spacing = numbers_of(tag("0028|0030"));
    double row = 0, column = 0, both = 0;
    for (std::size_t i = 0; i < 3 && axes.size() == 6; ++i) {
        row += axes[i] * axes[i];
        column += axes[3 + i] * axes[3 + i];
        both += axes[i] * axes[3 + i];
    }
    if (std::abs(row - 1) > 1e-3 || std::abs(column - 1) > 1e-3 || std::abs(both) > 1e-3)
        throw Fault(file + ": says no directions (0020,0037) of length 1 at right angles" + again);
    if (spacing.size() != 2 || spacing[0] <= 0 || spacing[1] <= 0)
        throw Fault(file + ": says no spacing of its pixels (0028,0030) above 0 mm" + again);
}

std::uint64_t dicom_pixel_bytes(const DicomTag &tag)
{
    const auto number = [&](const char *element) {
        return static_cast<std::uint64_t>(std::clamp(number_of(tag(element)), 0.0, 65535.0));
    };
    return number("0028|0010") * number("0028|0011") * number("0028|0100") / 8;
}

DicomOwner dicom_owner(const DicomTag &tag)
{
    return {tag("0010|0010") + "/" + tag("0010|0020"), tag("0010|0030"), tag("0020|000d"), tag("0020|0052")};
}

std::string difference_of(const DicomOwner &a, const DicomOwner &b)
{
    if (a.patient != b.patient || a.birth != b.birth) return "patients";
    if (a.study != b.study) return "studies";
    return a.frame != b.frame ? "frames of reference" : "";
}

} // namespace crn::ct
