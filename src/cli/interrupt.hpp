#pragma once

namespace viscobar::cli {

/// From now on SIGINT and SIGTERM only set a flag; a second one ends the program at once.
void catch_interrupts();
bool interrupt_asked();

}  // namespace viscobar::cli
