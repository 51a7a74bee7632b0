/* The commands `anatomy person` and `anatomy seeds`. */
#pragma once
#include "tools/anatomy/program/making.hpp"
#include "tools/anatomy/varied/persons.hpp"

namespace CLI
{
class App;
}

namespace anatomy
{

class PersonCommand
{
  public:
    /* Adds both commands. `add_making` adds the options that all commands share which make scenes. */
    PersonCommand(CLI::App &app, void (*add_making)(CLI::App &, Options &));
    /* Runs the command that was given on the command line; returns nothing if it was neither. */
    std::optional<int> run();

  private:
    int make();
    int check_seeds() const;
    CLI::App *person_, *seeds_;
    Options options_;
    PersonWish wish_;
    std::string sex_, arch_, arms_ = "raised";
    std::vector<std::string> clutter_;
    std::uint64_t seed_ = 0, from_ = 0, count_ = 500;
};

} // namespace anatomy
