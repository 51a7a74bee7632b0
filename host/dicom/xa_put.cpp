#include "host/dicom/xa_put.hpp"
#include "host/base/number_text.hpp"
#include <cmath>
#include <stdexcept>

namespace crn
{

namespace
{

void check(const OFCondition &condition, const DcmTagKey &tag)
{
    if (condition.bad())
        throw std::logic_error("DICOM attribute " + std::string(tag.toString().c_str()) + ": " +
                               condition.text());
}

} // namespace

std::string decimal_string(double value)
{
    if (!std::isfinite(value)) throw std::invalid_argument("a DICOM attribute would not be a finite number");
    if (std::abs(value) < 1e-9) return "0"; // also for -0
    std::string text;
    for (int digits = 9; text.empty() || text.size() > 16; --digits) text = number_text(value, digits);
    return text;
}

void XaItem::text(const DcmTagKey &tag, const std::string &value)
{
    check(item_.putAndInsertOFStringArray(tag, OFString(value.c_str())), tag);
}

void XaItem::empty(const DcmTagKey &tag)
{
    check(item_.insertEmptyElement(tag), tag);
}

void XaItem::decimal(const DcmTagKey &tag, double value)
{
    text(tag, decimal_string(value));
}

void XaItem::decimals(const DcmTagKey &tag, const std::vector<double> &values)
{
    std::string all;
    for (std::size_t i = 0; i < values.size(); i++) all += (i > 0 ? "\\" : "") + decimal_string(values[i]);
    text(tag, all);
}

void XaItem::decimal_if_known(const DcmTagKey &tag, double value)
{
    if (value == 0.0)
        empty(tag);
    else
        decimal(tag, value);
}

void XaItem::whole(const DcmTagKey &tag, long value)
{
    text(tag, std::to_string(value));
}

void XaItem::shorts(const DcmTagKey &tag, const std::vector<std::uint16_t> &values)
{
    check(item_.putAndInsertUint16Array(tag, values.data(), values.size()), tag);
}

void XaItem::floats(const DcmTagKey &tag, const std::vector<float> &values)
{
    check(item_.putAndInsertFloat32Array(tag, values.data(), values.size()), tag);
}

void XaItem::private_longs(std::uint16_t element, const std::vector<std::uint32_t> &values)
{
    const DcmTag tag(DcmTagKey(private_group, element), DcmVR(EVR_UL));
    check(item_.putAndInsertUint32Array(tag, values.data(), values.size()), tag);
}

void XaItem::private_doubles(std::uint16_t element, const std::vector<double> &values)
{
    const DcmTag tag(DcmTagKey(private_group, element), DcmVR(EVR_FD));
    check(item_.putAndInsertFloat64Array(tag, values.data(), values.size()), tag);
}

} // namespace crn
