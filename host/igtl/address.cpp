#include "host/igtl/address.hpp"
#include <charconv>
#include <stdexcept>

namespace crn
{

bool IgtlAddress::is_local() const
{
    return host.rfind("127.", 0) == 0 || host == "::1" || host == "localhost";
}

std::string IgtlAddress::text() const
{
    const bool is_ipv6 = host.find(':') != std::string::npos;
    return (is_ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

IgtlAddress parse_igtl_address(const std::string &text)
{
    const std::size_t colon = text.rfind(':');
    IgtlAddress address;
    const std::string digits = colon == std::string::npos ? text : text.substr(colon + 1);
    if (colon != std::string::npos) address.host = text.substr(0, colon);
    const bool has_brackets =
        address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']';
    if (has_brackets) address.host = address.host.substr(1, address.host.size() - 2);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), address.port, 10);
    const bool is_number = error == std::errc() && end == digits.data() + digits.size();
    const bool is_host =
        !address.host.empty() && address.host.find_first_of(has_brackets ? "[]" : "[]:") == std::string::npos;
    if (!is_number || !is_host)
        throw std::runtime_error(
            "'" + text +
            "' is not PORT, HOST:PORT or [IPV6]:PORT with a port of 0 .. 65535; 3D Slicer "
            "expects 18944");
    return address;
}

} // namespace crn
