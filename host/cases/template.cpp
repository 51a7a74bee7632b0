// Contains the template file that the command `cournand case new` writes.
#include "host/cases/case.hpp"

namespace crn
{

namespace
{

constexpr const char *template_text = R"(# A case for trainees: docs/cases.md explains every key.
# Try it:    cournand case check NAME
#            cournand case check NAME --play
#            cournand case play NAME
format = 1
title = "My first case"
# order = 500                    # lists of cases are sorted by this number
aim = "Bring the tip of the wire into the ascending aorta."
story = """
A sheath lies in the right femoral artery. The next step of the examination is a wire in the ascending aorta. Say here
who comes, why, and what has been done already."""
teaching = """
Say here what the case teaches: a J tip opens no side branch, and a hand that turns while it pushes passes branches more
easily."""
hints = [
    "The first hint is shown to a trainee who is stuck.",
    "The second hint may give more away.",
]
# picture = "my_picture.png"     # without this key: NAME.png, if it is beside this file

[patient]
invented = true                  # a case never holds the data of a real person
name = "Example, Alex"
sex = "male"                     # or female
age_years = 67
indication = "Chest pain on exertion."
# history = "High blood pressure for ten years."

[anatomy]
kind = "aorta"                   # aorta, heart, phantom or access (docs/anatomy.md)
# vessels = "arch_type_2"        # name or file of other vessels (docs/vessels.md)
# lesions = ["renal_ostium"]     # names or files of lesions (docs/lesions.md)
# scene = "my.scene"             # instead of all this: a scene that you have baked

[devices]
offered = ["j_wire", "bentson"]  # on the table, at most eight: cournand instruments
# stents = ["renal_6_0x18"]

[start]
tools = ["j_wire"]               # on the line at the start, the innermost first, at most three; "nothing" is free
inserted_mm = [20]               # one length for each tool, 0 where nothing is
room = ["view ap", "field 32 cm", "follow tip"]   # statements of docs/session.md for the X-ray room

# What must be true, in the words of `expect` (docs/session.md), at the end or at any moment ("once").
[[goal]]
text = "The tip passes the renal arteries."
expect = "tip wire in descending aorta"
when = "once"
marks = 20

[[goal]]
text = "The tip lies in the ascending aorta."
expect = "tip wire in ascending aorta at least 20 mm"
marks = 50

# What should not become large: all marks up to the first value, none from the second on.
[[limit]]
measure = "time_min"
full_marks_at = 2
no_marks_at = 4
marks = 10

[[limit]]
measure = "hand_force_N"
full_marks_at = 3
no_marks_at = 8
marks = 20

# How well an expert and a clumsy beginner do: `cournand case check NAME --play` wants 90 and 60 of 100.
[scripts]
expert = "NAME_expert.session"
clumsy = "NAME_clumsy.session"
)";

constexpr const char *expert_text =
    R"(# The expert pushes gently, and turns the wire where the arch's branches leave.
fluoro on
advance 300 mm at 70 mm/s in strokes of 90 mm
advance 150 mm at 70 mm/s in strokes of 75 mm
steer into ascending aorta at 60 mm/s until 40 mm
fluoro off
)";

constexpr const char *clumsy_text = R"(# The beginner forgets the X-ray, pushes on and never turns.
advance 300 mm at 200 mm/s
advance 700 mm at 300 mm/s
wait 60 s
)";

std::string with_name(std::string text, const std::string &name)
{
    const std::string word = "NAME";
    for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + name.size()))
        text.replace(at, word.size(), name);
    return text;
}

} // namespace

std::string case_template(const std::string &name)
{
    return with_name(template_text, name);
}

std::vector<NamedText> template_scripts(const std::string &name)
{
    return {{name + "_expert.session", expert_text}, {name + "_clumsy.session", clumsy_text}};
}

} // namespace crn
