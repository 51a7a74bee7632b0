#include "tools/patient/choices.hpp"
#include "host/base/format.hpp"

namespace crn::patient
{

void Choices::add(const std::string &what, const std::string &value, const std::string &why,
                  const std::string &flag)
{
    list_.push_back({what, value, why, flag});
}

std::string Choices::text(const std::string &begin) const
{
    std::string text;
    for (const Choice &choice : list_) {
        text += formatted("%s%-9s %s", begin.c_str(), choice.what.c_str(), choice.value.c_str());
        if (!choice.why.empty()) text += ": " + choice.why;
        if (!choice.flag.empty()) text += " (" + choice.flag + ")";
        text += "\n";
    }
    return text;
}

} // namespace crn::patient
