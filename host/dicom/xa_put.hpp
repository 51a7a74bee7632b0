// Writes attributes into a DICOM item with one short call each, and formats numbers as the standard requires.
#pragma once
#include <cstdint>
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcdatset.h>
#include <dcmtk/dcmdata/dcdeftag.h>
#include <string>
#include <vector>

namespace crn
{

// Returns text like "0.625": as many digits as are significant, at most the 16 characters of a DS.
std::string decimal_string(double value);

class XaItem
{
  public:
    explicit XaItem(DcmItem &item) : item_(item) {}

    void text(const DcmTagKey &tag, const std::string &value);
    void empty(const DcmTagKey &tag); // type 2: value not known
    void decimal(const DcmTagKey &tag, double value);
    void decimals(const DcmTagKey &tag, const std::vector<double> &values);
    // Writes an attribute of DICOM type 2, which may be empty: the attribute is empty when the value is 0,
    // which means not known.
    void decimal_if_known(const DcmTagKey &tag, double value);
    void whole(const DcmTagKey &tag, long value);                                // IS
    void shorts(const DcmTagKey &tag, const std::vector<std::uint16_t> &values); // US
    void floats(const DcmTagKey &tag, const std::vector<float> &values);         // FL
    void private_longs(std::uint16_t element, const std::vector<std::uint32_t> &values);
    void private_doubles(std::uint16_t element, const std::vector<double> &values);
    DcmItem &item() { return item_; }

  private:
    DcmItem &item_;
};

// The private block of the DICOM file holds values for which the classic XA object has no attribute, with one
// value per frame (docs/output.md).
inline constexpr std::uint16_t private_group = 0x0023;
inline constexpr const char *private_creator = "COURNAND 1.0";

// Writes the attributes of the X-ray beam and of the C-arm: tube, dose, filter, collimator, table and C-arm
// angles (xa_beam.cpp).
struct XrayRun;
void put_acquisition(XaItem &item, const XrayRun &run);
void put_collimator(XaItem &item, const XrayRun &run);
void put_table(XaItem &item, const XrayRun &run);
void put_positioner(XaItem &item, const XrayRun &run);
void put_frames_private(XaItem &item, const XrayRun &run);

} // namespace crn
