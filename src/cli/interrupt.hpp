#pragma once

namespace viscobar::cli {

/// From now on SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) only set a flag; a second one ends the
/// program at once.
void catch_interrupts();
bool interrupt_asked();

/// From now on the same signals end the program with exit code 130: for work that leaves nothing half done.
void end_on_interrupt();

}  // namespace viscobar::cli
