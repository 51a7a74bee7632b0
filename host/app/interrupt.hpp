// Ctrl-C and SIGTERM as a question: loops ask, close their files and end. May include: model/pending_file.
#pragma once

namespace seld
{

// From now on the first Ctrl-C or SIGTERM only raises the flag; a second one ends the program,
// and files under way are removed.
void watch_for_interrupt();
bool is_interrupted();

} // namespace seld
