// What the making of a scene decided: printed, and written into the scene's text, so that a person can decide
// otherwise.
#pragma once
#include <string>
#include <vector>

namespace crn::patient
{

struct Choice {
    std::string what;  // "unit"
    std::string value; // "mm"
    std::string why;
    std::string flag; // "--unit m": how to decide otherwise; empty: a fact
};

class Choices
{
  public:
    void add(const std::string &what, const std::string &value, const std::string &why,
             const std::string &flag);
    const std::vector<Choice> &all() const { return list_; }
    // One line each; `begin` stands before every line ("# " in a scene's text).
    std::string text(const std::string &begin) const;

  private:
    std::vector<Choice> list_;
};

} // namespace crn::patient
