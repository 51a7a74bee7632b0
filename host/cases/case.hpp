// Reads case files (TOML, docs/cases.md). A case is an exercise for a trainee: an anatomy with lesions, the
// offered tools, the situation at the start, and goals to reach. A teacher writes a case as a text file,
// without changing the program.
//
//   const Case lesson = read_case(example_path(case_files, "first_push"));
#pragma once
#include "host/base/examples.hpp"
#include "host/cases/recipe.hpp"
#include "host/script/session.hpp"
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

inline constexpr std::size_t case_tools_max = CRN_WIRE_TABLE_MAX; // tools of the table
inline constexpr double case_expert_least = 90.0;                 // score of the expert's script, at least
inline constexpr double case_clumsy_most = 60.0;                  // score of the clumsy script, at most
inline constexpr double case_marks_standard = 10;                 // of a goal or limit that states no marks

// The patient of a case is fictitious, and every case file states this.
struct CasePatient {
    std::string name, sex, indication, history;
    int age_years = 0;
};

// Holds a condition in the words of the script statement `expect` (docs/session.md). A goal must hold at the
// end of the session, or at any moment of the session if `is_once` is true. Of the goals with `is_once`, each
// counts only from the moment at which all earlier ones have been reached.
struct CaseGoal {
    int line = 0;
    std::string text; // for the trainee
    Expectation expectation;
    bool is_once = false;
    double marks = case_marks_standard;
};

// Limits a quantity of the session's report. A value up to `full_at` earns all marks, a value from `none_at`
// on earns none, and a value in between earns some of the marks.
struct CaseLimit {
    int line = 0;
    std::string measure; // one of case_measures()
    double full_at = 0.0, none_at = 0.0;
    double marks = case_marks_standard;
};

// Describes which tools are nested in the vessels when the case begins. The lists have one entry for each
// position on the line (the nested tools), from the innermost to the outermost.
struct CaseStart {
    int line = 0;
    std::vector<std::string> tools; // paths, maybe with ":preset"; empty at a free position
    LineNumbers numbers;            // of these tools in `offered`, from 1; 0 at a free position
    std::vector<std::uint32_t> inserted_um;
    std::vector<std::string> room_words; // statements of a session script for C-arm, table and field
    std::vector<Statement> room;         // the same, parsed
};

struct NamedVessel {
    std::string name;
    int line = 0;
};

struct Case {
    std::string name; // of the file, without its ending
    std::string file;
    int order = 500; // lists of cases are sorted by this number
    std::string title, aim, story, teaching;
    std::vector<std::string> hints;
    CasePatient patient;
    Recipe recipe;
    std::vector<std::string> offered; // paths of the tools of the table, at most case_tools_max
    std::vector<std::string> stents;  // paths, in the order of loading
    CaseStart start;
    std::vector<CaseGoal> goals;
    std::vector<CaseLimit> limits;
    std::string expert, clumsy;  // paths of the scripts
    std::string picture;         // path of the picture beside the file, or empty if there is none
    bool has_assessment = false; // the table [assessment], which host/assess reads
    std::vector<NamedVessel> assessed_vessels; // of its table [assessment.vessels]
};

// Throws a FileError "FILE:LINE:COLUMN: what is wrong", with a suggestion for a misspelt word.
Case read_case(const std::string &path);

// Returns the paths of all case files: the user's own first, then those that come with the program. If two
// cases have the same name, the later one is left out.
std::vector<std::string> case_paths();

// Returns the session for a script of a case: the statements that set up the X-ray room at the start of the
// case, followed by the script's own statements. The session begins with the case's tools in the vessels,
// with their inserted lengths; the session's table holds the offered tools.
Session case_session(const Case &lesson, const std::string &script);
// Returns the words of a `begin with` statement for nested tools, which are given by their numbers in the
// session's table of tools.
std::vector<std::string> line_words(const LineNumbers &numbers);

// Returns a case file with comments as a template, which a teacher can change. The template passes the check
// as soon as the two scripts (template_scripts) are beside it.
std::string case_template(const std::string &name);
struct NamedText {
    std::string name, text;
};
std::vector<NamedText> template_scripts(const std::string &name);

} // namespace crn
