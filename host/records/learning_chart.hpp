// Draws curves over the number of the session as SVG, for the pages of a trainee and of a cohort.
#pragma once
#include <string>
#include <vector>

namespace crn
{

class LearningChart
{
  public:
    // `title` is the text that a screen reader reads aloud, and `unit` is the label of the vertical axis.
    // `sessions` is the largest session number on the horizontal axis.
    LearningChart(std::string title, std::string unit, std::size_t sessions);
    // An area between two lines of the sessions 1, 2, ...
    void band(const std::vector<double> &low, const std::vector<double> &high, const char *colour,
              double opacity);
    void line(const std::vector<double> &values, const char *colour, const char *dashes = "");
    void level(double value, const char *colour, const char *dashes, const std::string &label);
    void area(double low, double high, const char *colour); // over all sessions
    void dots(const std::vector<double> &values, const std::vector<std::string> &labels, const char *colour);
    std::string svg() const;

  private:
    struct Mark {
        enum class Kind { band, line, level, area, dots } kind;
        std::vector<double> values, more;
        std::vector<std::string> labels;
        std::string colour, dashes;
        double opacity = 1.0;
    };
    std::string title_, unit_;
    std::size_t sessions_;
    std::vector<Mark> marks_;
};

} // namespace crn
