#pragma once

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <thread>

namespace viscobar {

/// Text that a command shows on a terminal: its standard error is the slave of a pseudo-terminal, read while it runs.
inline std::string shown_on_terminal(const std::string& command) {
  int master = -1, slave = -1;
  char name[128] = {};
  if (openpty(&master, &slave, name, nullptr, nullptr) != 0) return "no pseudo-terminal";
  std::string text;
  std::thread reader([&] {
    char buffer[4096];
    for (ssize_t count = 0; (count = read(master, buffer, sizeof buffer)) > 0;)
      text.append(buffer, static_cast<std::size_t>(count));
  });
  EXPECT_NE(std::system((command + " 2>" + name).c_str()), -1);
  close(slave);  // the last one that holds it: the reader sees the end
  reader.join();
  close(master);
  return text;
}

}  // namespace viscobar
