// Runs the emulated board in real time while a command runs, so that the command sees the board on its USB
// through the bridge of L3 or the mocked bus of L2.
#pragma once
#include <string>
#include <vector>

namespace hil
{

// In the words of the command, `{mailbox}` is replaced by the place of the USB tokens (FILE:OFFSET). Returns
// the command's exit code, or 1 if it could not be started. The rig rests.
int serve_board(const std::string &image, const std::vector<std::string> &command);

} // namespace hil
