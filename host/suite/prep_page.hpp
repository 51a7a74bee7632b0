// Draws the preparation of a case: the patient, the goals, the devices and whether they fit into each other,
// a picture, and the progress of making the scene. In the preparation the trainee chooses the devices with
// which the session begins; the others stay on the device table, and can be brought into use during the
// session.
#pragma once
#include "host/cases/recipe.hpp"
#include "host/live/background_task.hpp"
#include "host/stent/design.hpp"
#include "host/suite/case_card.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/ui.hpp"
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// One device on the table.
struct CabinetDevice {
    std::string path;
    Instrument instrument;
    bool is_on_line = false;
};

// Holds the devices that a case offers, and those of them that the trainee has chosen for the start. There
// are as many positions (places for nested devices) as the case has at its start. A device with which the
// case begins keeps its position, if the other devices permit it.
class DeviceCabinet
{
  public:
    static constexpr std::size_t line_max = 3;

    // Throws FileError if an instrument cannot be read.
    explicit DeviceCabinet(const Case &lesson);
    const std::vector<CabinetDevice> &devices() const { return devices_; }
    void toggle(std::size_t device);
    // Returns the devices in use at the start, beginning with the innermost, which is the thinnest.
    const std::vector<std::size_t> &line() const { return line_; }
    std::vector<std::string> paths() const; // of the whole table
    // Returns the device at each position, from the innermost; a position without a device has no value.
    std::vector<std::optional<std::size_t>> positions() const;
    // Returns the words of the option --line: for each position, the number that its device has in the
    // session's table.
    std::vector<std::string> line_words() const;
    std::vector<double> inserted_mm() const; // where the device at each position begins

    struct Finding {
        bool is_good = true;
        std::string text;
    };
    // States for each pair of neighbouring devices whether the inner one passes through the outer one, and
    // why.
    const std::vector<Finding> &findings() const { return findings_; }
    // Returns the reason why the case cannot begin with these devices, or an empty text if it can.
    std::string refusal() const;

  private:
    void look_at_line();
    std::vector<std::size_t> sorted_line() const;
    std::vector<Finding> found() const;

    const Case &lesson_;
    std::vector<CabinetDevice> devices_;
    std::vector<StentDesign> stents_;
    // The devices in use and the findings about them are computed when the choice changes, because the window
    // shows them sixty times a second.
    std::vector<std::size_t> line_;
    std::vector<Finding> findings_;
};

// Returns a text about a limit, such as "largest hand force: 5 marks up to 4 N, none from 10 N".
std::string limit_text(const CaseLimit &limit);

class PrepPage
{
  public:
    // `card` must be the card of a case. The constructor at once begins to make the scene in the background.
    // Throws FileError.
    PrepPage(Ui &ui, CaseCard card);

    PageChoice draw();
    // Chooses a device for the start of the session, or undoes this choice; a number that no device of the
    // case has changes nothing.
    void toggle(std::size_t device);
    // Returns true if a session can begin.
    bool is_ready() const { return scene_.result() && cabinet_.refusal().empty(); }
    // Returns the options of a session with the chosen devices; call this function only when is_ready() is
    // true.
    WindowOptions options() const;
    const Case &lesson() const { return *card_.options.lesson; }
    const CaseCard &card() const { return card_; }

  private:
    void draw_patient();
    void draw_goals();
    void draw_cabinet();
    void draw_device(std::size_t device, const std::vector<std::optional<std::size_t>> &line);
    void draw_side(const UiRect &place, PageChoice &choice);
    void draw_scene_state();

    Ui &ui_;
    std::uint64_t version_; // of the picture's texture
    CaseCard card_;
    DeviceCabinet cabinet_;
    BackgroundTask<PreparedScene> scene_; // the last member, because it uses the others
};

} // namespace crn
